"""The command `fieldrig pam rig`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig_devices.pam.commands.checking import File, IgnoresCase, compiled


def rig(
    file: File,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the rig file, beside FILE.")] = None,
    is_virtual: Annotated[bool, typer.Option("--virtual", help="Make it a rig in virtual time.")] = False,
    ignores_case: IgnoresCase = False,
) -> None:
    """Write a rig file with the PAM and all nodes that an application declares.

    \b
        fieldrig pam rig packer.pam --out packer.yaml
        fieldrig up packer.yaml

    Connect the machine behind the nodes to the wires of their terminals. The exit code is 2 if the application has
    mistakes.
    """
    from fieldrig.system.whole_file import replace_file
    from fieldrig_devices.pam.rig_file import rig_file

    program = compiled(file, ignores_case=ignores_case).program
    text = rig_file(program, file.name, is_virtual=is_virtual, ignores_case=ignores_case)
    if out is None:
        typer.echo(text, nl=False)
        return
    with writing(out):
        replace_file(out, text.encode())
