"""The command `fieldrig pam fmt`."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument
from fieldrig_devices.languages.formatting import IsCheck, format_files
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.pam.commands.checking import read_text

Files = Annotated[list[Path], argument("FILE...", "The source files.")]


def fmt(files: Files, is_check: IsCheck = False) -> None:
    """Write source files in one layout, with their comments and directives.

    A file with signs that have no meaning in a program, or with none of the words of a PAM, stays as it is.

    \b
        fieldrig pam fmt packer.pam
        fieldrig pam fmt *.pam --check
        fieldrig pam fmt - < packer.pam

    With -, the standard input is formatted and written to the standard output.
    """
    format_files(files, _read, _printed, is_check=is_check)


def _read(files: Sequence[Path]) -> Iterator[SourceFile]:
    return (SourceFile(str(file), read_text(file)) for file in files)


def _printed(text: str, name: str) -> str | None:
    """Return a text in one layout, or None if it is no text of a PAM, which is said."""
    from fieldrig_devices.pam.language.formatter import formatted, strangers

    found = strangers(text, name)
    for mistake in found:
        typer.echo(str(mistake), err=True)
    return None if found else formatted(text)
