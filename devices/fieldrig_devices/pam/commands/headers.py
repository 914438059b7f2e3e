"""The command `fieldrig pam headers`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import argument, writing
from fieldrig.system.exits import Exit
from fieldrig_devices.pam.commands.checking import IgnoresCase, read_text

File = Annotated[Path, argument("FILE", "The source file of the application.")]


def headers(
    file: File,
    into: Annotated[Path, typer.Option("--into", metavar="FOLDER", help="Folder of the include files.")] = Path(),
    ignores_case: IgnoresCase = False,
) -> None:
    """Write the include files for the VME master of an application in C.

    \b
        fieldrig pam headers packer.pam --into AGL

    PAM_VME.H has the CRC of each variable, VMECLASS.H the codes of their classes, and PAM_DEF.H the memory.
    """
    from fieldrig.system.whole_file import replace_file
    from fieldrig_devices.pam.application_files import reader_beside
    from fieldrig_devices.pam.language.compiler import checked
    from fieldrig_devices.pam.language.ports import ports_of
    from fieldrig_devices.pam.ports.options import PortOptions
    from fieldrig_devices.pam.ports.vme.headers import headers as texts

    program, all_mistakes = checked(read_text(file), str(file), reader_beside(file), ignores_case=ignores_case)
    mistakes = [mistake for mistake in all_mistakes if not mistake.is_note]
    for mistake in mistakes:
        typer.echo(str(mistake), err=True)
    plans = [plan for plan in ports_of(program) if plan.kind == "VME DUALPORT"] if not mistakes else []
    if not plans:
        if not mistakes:
            typer.echo(f"{file} has no VME DUALPORT.", err=True)
        raise typer.Exit(Exit.WRONG)
    for name, text in texts(plans[0], PortOptions()).items():
        with writing(into):
            replace_file(into / name, text.encode())
        typer.echo(f"{into / name}: written")
