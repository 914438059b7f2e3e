"""The commands `fieldrig editor install` and `fieldrig editor pack`."""

import sys
import tempfile
from pathlib import Path
from typing import Annotated

import typer

from fieldrig.cli.common import writing
from fieldrig.errors import UsageError


def install(
    into: Annotated[
        Path | None,
        typer.Option("--into", metavar="FOLDER", help="Unpack it into this folder of extensions.", show_default=False),
    ] = None,
) -> None:
    """Install the extension into the editors of this machine.

    \b
        fieldrig editor install
        fieldrig editor install --into ~/.vscode-server/extensions

    An editor whose command is on the path (code, codium, code-server) installs it itself. If there is none, it is
    unpacked into the folders of extensions that the home folder has.
    """
    from fieldrig_devices.editor import editors
    from fieldrig_devices.editor.package import extension_files, manifest
    from fieldrig_devices.editor.vsix import vsix

    described, files = manifest(), extension_files((sys.executable, "-m", "fieldrig"))
    if into is None and (commands := editors.with_command()):
        with tempfile.TemporaryDirectory() as folder:
            package = Path(folder) / f"fieldrig-{described['version']}.vsix"
            package.write_bytes(vsix(described, files))
            for editor, command in commands:
                editors.install_by_command(command, package)
                typer.echo(f"{editor.name} has installed the extension, by `{editor.command} --install-extension`.")
        return
    folders = [("", into)] if into is not None else [(one.name, path) for one, path in editors.with_folder(Path.home())]
    if not folders:
        raise UsageError(
            "there is no editor: neither a command such as `code`, nor a folder such as ~/.vscode",
            "`fieldrig editor pack` writes a .vsix file for another machine",
        )
    for name, path in folders:
        with writing(path):
            own = editors.unpack(path, described, files)
        typer.echo(f"The extension is unpacked into {own}{f' for {name}' if name else ''}; start the editor again.")


def pack(
    out: Annotated[
        Path | None,
        typer.Option("--out", metavar="FILE", help="The file.  [default: fieldrig-VERSION.vsix]", show_default=False),
    ] = None,
) -> None:
    """Write the extension as a .vsix file, which an editor installs by `code --install-extension FILE`.

    \b
        fieldrig editor pack
        fieldrig editor pack --out build/fieldrig.vsix
    """
    from fieldrig.system.whole_file import replace_file
    from fieldrig_devices.editor.package import extension_files, manifest
    from fieldrig_devices.editor.vsix import vsix

    described = manifest()
    file = out or Path(f"{described['name']}-{described['version']}.vsix")
    with writing(file):
        replace_file(file, vsix(described, extension_files()))
    typer.echo(f"written: {file}")
