"""The command `fieldrig pam doc`."""

from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig_devices.pam.commands.checking import File, IgnoresCase, compiled


def doc(
    file: File,
    out: Annotated[
        Path | None, typer.Option("--out", metavar="FILE", help="Write the listing to a file, such as packer.doc.")
    ] = None,
    ignores_case: IgnoresCase = False,
) -> None:
    """List the names of an application with their compiler IDs, and its sequences with their numbers and workspaces.

    \b
        fieldrig pam doc packer.pam
        fieldrig pam doc packer.pam --out packer.doc

    Messages of the PAM name objects by compiler IDs, and sequences by numbers such as S003. The exit code is 2 if the
    application has mistakes.
    """
    from fieldrig.system.whole_file import replace_file
    from fieldrig_devices.pam.runtime.listing import listing

    text = listing(compiled(file, ignores_case=ignores_case))
    if out is None:
        typer.echo(text, nl=False)
        return
    with writing(out):
        replace_file(out, text.encode())
