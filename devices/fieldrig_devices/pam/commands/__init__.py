"""`fieldrig pam`: commands for applications of the PAM."""

from fieldrig.cli.common import command_group
from fieldrig_devices.languages.debugging.debug_command import debug
from fieldrig_devices.pam.commands.checking import check
from fieldrig_devices.pam.commands.formatting import fmt
from fieldrig_devices.pam.commands.headers import headers
from fieldrig_devices.pam.commands.listing import doc
from fieldrig_devices.pam.commands.rig import rig
from fieldrig_devices.pam.commands.running import run

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
app = command_group()


@app.callback()
def pam() -> None:
    """Check, format, list, run and debug applications of the Socapel PAM.

    \b
        fieldrig pam check packer.pam
        fieldrig pam fmt packer.pam
        fieldrig pam headers packer.pam
        fieldrig pam run packer.pam
        fieldrig pam rig packer.pam --out packer.yaml
        fieldrig pam debug pam
    """


app.command()(check)
app.command()(fmt)
app.command()(headers)
app.command()(doc)
app.command()(run)
app.command()(rig)
app.command()(debug)
