"""The command `fieldrig pam check`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, argument, reading
from fieldrig.points.values import counted
from fieldrig.system.exits import Exit
from fieldrig_devices.languages.told_mistakes import tell

if TYPE_CHECKING:
    from fieldrig_devices.languages.mistakes import Mistake
    from fieldrig_devices.pam.language.items import Program
    from fieldrig_devices.pam.runtime.compiler import Compiled

File = Annotated[Path, argument("FILE", "The source file of the application; it may include others beside it.")]

IgnoresCase = Annotated[
    bool, typer.Option("--ignore-case", help="Take names as the same in any case (programs.ignores_case of the rig).")
]


def read_text(path: Path) -> str:
    """Return the text of a source file."""
    from fieldrig.text.source_text import decoded

    with reading(path):
        return decoded(path.read_bytes())


def compiled(file: Path, *, ignores_case: bool) -> "Compiled":
    """Compile an application, or list its mistakes and exit."""
    from fieldrig_devices.languages.mistakes import CompileError
    from fieldrig_devices.pam.application_files import reader_beside
    from fieldrig_devices.pam.runtime.compiler import compile_application

    try:
        return compile_application(read_text(file), str(file), reader_beside(file), ignores_case=ignores_case)
    except CompileError as wrong:
        for mistake in wrong.mistakes:
            typer.echo(str(mistake), err=True)
        raise typer.Exit(Exit.WRONG) from wrong


def looked_through(file: Path, *, ignores_case: bool) -> "tuple[Program, list[Mistake]]":
    """Return an application with its mistakes and notes."""
    from fieldrig_devices.pam.application_files import reader_beside
    from fieldrig_devices.pam.language.compiler import checked
    from fieldrig_devices.pam.runtime.compiler import too_large, wrong_counts

    program, mistakes = checked(read_text(file), str(file), reader_beside(file), ignores_case=ignores_case)
    return program, mistakes + (too_large(program, mistakes) or wrong_counts(program, mistakes))


def check(file: File, as_json: AsJson = False, ignores_case: IgnoresCase = False) -> None:
    """Check an application, and list all its mistakes at once.

    \b
        fieldrig pam check packer.pam

    The exit code is 0 if the application is right, and 2 if it has mistakes. Notes, such as old names that release 2.5
    still takes, are no mistakes.
    """
    program, mistakes = looked_through(file, ignores_case=ignores_case)
    tell(mistakes, f"{file} is right: {counted(len(program.items), 'object')}.", as_json=as_json)
