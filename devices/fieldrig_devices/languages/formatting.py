"""Formats source files for the commands `fmt`: in place, from the standard input, or only to see whether they are."""

from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.system.exits import Exit
from fieldrig_devices.languages.source_file import SourceFile
from fieldrig_devices.languages.standard_streams import is_standard, read_standard, write_standard

IsCheck = Annotated[
    bool, typer.Option("--check", help="Change nothing; the exit code is 2 if a file is not formatted.")
]
Printed = Callable[[str, str], str | None]
"""Returns a text with this name in one layout; None if it has mistakes, which it says."""


def format_files(
    paths: Sequence[Path], read: Callable[[Sequence[Path]], Iterable[SourceFile]], printed: Printed, *, is_check: bool
) -> None:
    """Format the files at paths, or the standard input for `-`.

    Ends the command if one has mistakes, and with `is_check` if one is not formatted.
    """
    from fieldrig.system.whole_file import replace_file

    if is_standard(paths):
        text = printed(read_standard(), "-")
        if text is None:
            raise typer.Exit(Exit.WRONG)
        write_standard(text)
        return
    is_wrong = False
    for source in read(paths):
        text = printed(source.text, source.name)
        is_wrong = is_wrong or text is None
        if text is None or text == source.text:
            continue
        typer.echo(f"{source.name}: {'not formatted' if is_check else 'formatted'}")
        is_wrong = is_wrong or is_check
        if not is_check:
            with writing(Path(source.name)):
                replace_file(Path(source.name), text.encode())
    if is_wrong:
        raise typer.Exit(Exit.WRONG)
