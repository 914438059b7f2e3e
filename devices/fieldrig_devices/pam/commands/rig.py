"""The command `fieldrig pam rig`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig_devices.pam.commands.checking import File, compiled


def rig(
    file: File,
    out: Annotated[Path | None, typer.Option("--out", metavar="FILE", help="Write the rig file, beside FILE.")] = None,
    is_virtual: Annotated[bool, typer.Option("--virtual", help="Make it a rig in virtual time.")] = False,
) -> None:
    """Write a rig file with the PAM and all nodes that an application declares.

    \b
        fieldrig pam rig packer.pam --out packer.yaml
        fieldrig up packer.yaml

    Connect the machine behind the nodes to the wires of their terminals. The exit code is 2 if the application has
    mistakes.
    """
    from fieldrig.store import replace_file
    from fieldrig_devices.pam.rig_file import rig_file

    text = rig_file(compiled(file).program, file.name, is_virtual=is_virtual)
    if out is None:
        typer.echo(text, nl=False)
        return
    with writing(out.parent):
        replace_file(out, text.encode())
