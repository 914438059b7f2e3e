"""The command `fieldrig arp fmt`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument
from fieldrig_devices.arp.commands.checking import read_text
from fieldrig_devices.languages.formatting import IsCheck, format_files
from fieldrig_devices.languages.source_file import SourceFile

Files = Annotated[list[Path], argument("FILE...", "The source files.")]


def fmt(files: Files, is_check: IsCheck = False) -> None:
    """Write source files in one layout, with their comments, numbers and capitals as they are.

    A file with characters that have no meaning in a program stays as it is.

    \b
        fieldrig arp fmt cam.I01
        fieldrig arp fmt *.I01 --check
        fieldrig arp fmt - < cam.I01

    With -, the standard input is formatted and written to the standard output.
    """
    format_files(files, _read, _printed, is_check=is_check)


def _read(files: Sequence[Path]) -> Iterator[SourceFile]:
    return (SourceFile(str(file), read_text(file)) for file in files)


def _printed(text: str, name: str) -> str | None:
    """Return a text in one layout, or None if it is no text of an ARP, which is said."""
    from fieldrig_devices.arp.language.formatter import formatted, strangers

    found = strangers(text)
    for mistake in found:
        typer.echo(f"{name}:{mistake}", err=True)
    return None if found else formatted(text)
