"""The command `fieldrig pam fmt`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument, writing
from fieldrig.system.exits import Exit
from fieldrig_devices.languages.standard_streams import is_standard, read_standard, write_standard
from fieldrig_devices.pam.commands.checking import read_text

Files = Annotated[list[Path], argument("FILE...", "The source files.")]


def fmt(
    files: Files,
    is_check: Annotated[
        bool, typer.Option("--check", help="Change nothing; the exit code is 2 if a file is not formatted.")
    ] = False,
) -> None:
    """Write source files in one layout, with their comments and directives.

    A file with signs that have no meaning in a program, or with none of the words of a PAM, stays as it is.

    \b
        fieldrig pam fmt packer.pam
        fieldrig pam fmt *.pam --check
        fieldrig pam fmt - < packer.pam

    With -, the standard input is formatted and written to the standard output.
    """
    from fieldrig.storage.store import replace_file

    if is_standard(files):
        printed = _printed(read_standard(), "-")
        if printed is None:
            raise typer.Exit(Exit.WRONG)
        write_standard(printed)
        return
    is_wrong = False
    for file in files:
        text = read_text(file)
        printed = _printed(text, str(file))
        is_wrong = is_wrong or printed is None
        if printed is None or printed == text:
            continue
        typer.echo(f"{file}: {'not formatted' if is_check else 'formatted'}")
        is_wrong = is_wrong or is_check
        if not is_check:
            with writing(file.parent):
                replace_file(file, printed.encode())
    if is_wrong:
        raise typer.Exit(Exit.WRONG)


def _printed(text: str, name: str) -> str | None:
    """Return a text in one layout, or None if it is no text of a PAM, which is said."""
    from fieldrig_devices.pam.language.formatter import formatted, strangers

    found = strangers(text, name)
    for mistake in found:
        typer.echo(str(mistake), err=True)
    return None if found else formatted(text)
