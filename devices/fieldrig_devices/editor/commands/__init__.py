"""`fieldrig editor`: the extension for editors, and what it asks for."""

from fieldrig.cli.common import command_group
from fieldrig_devices.editor.commands.installing import install, pack
from fieldrig_devices.editor.commands.problems import problems
from fieldrig_devices.editor.commands.programs import programs
from fieldrig_devices.editor.commands.rigs import rigs

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
app = command_group()


@app.callback()
def editor() -> None:
    """Install the extension for Visual Studio Code, VSCodium and code-server.

    \b
        fieldrig editor install
        fieldrig editor pack --out build/fieldrig.vsix
    `problems`, `programs` and `rigs` are for extensions and scripts.
    """


app.command()(install)
app.command()(pack)
app.command()(problems)
app.command()(programs)
app.command()(rigs)
