"""The command `fieldrig pam fmt`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument, writing
from fieldrig.system.exits import Exit
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
    """
    from fieldrig.storage.store import replace_file
    from fieldrig_devices.pam.language.formatter import formatted, strangers

    is_wrong = False
    for file in files:
        text = read_text(file)
        if found := strangers(text, str(file)):
            for mistake in found:
                typer.echo(str(mistake), err=True)
            is_wrong = True
            continue
        printed = formatted(text)
        if printed == text:
            continue
        typer.echo(f"{file}: {'not formatted' if is_check else 'formatted'}")
        is_wrong = is_wrong or is_check
        if not is_check:
            with writing(file.parent):
                replace_file(file, printed.encode())
    if is_wrong:
        raise typer.Exit(Exit.WRONG)
