"""`fieldrig iec`: commands for programs of IEC 61131-3."""

from fieldrig.cli.common import command_group
from fieldrig_devices.iec.commands.checking import check
from fieldrig_devices.iec.commands.downloading import download
from fieldrig_devices.iec.commands.formatting import fmt
from fieldrig_devices.iec.commands.mutating import mutate
from fieldrig_devices.iec.commands.running import run
from fieldrig_devices.iec.commands.symbols import symbols
from fieldrig_devices.iec.commands.testing import run_tests

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
app = command_group()


@app.callback()
def iec() -> None:
    """Check, format, run and test programs of IEC 61131-3, and load them into controllers.

    \b
    Files are Structured Text or Instruction List (.st, .il, .exp), PLCopen XML, or files of TwinCAT 3:
        fieldrig iec check conveyor.st
        fieldrig iec run traffic-light.st
        fieldrig iec test project/
        fieldrig iec mutate project/
        fieldrig iec fmt *.st
        fieldrig iec download controller conveyor.st
    `fieldrig debug` is the debugger.
    """


app.command()(check)
app.command()(fmt)
app.command()(run)
app.command()(download)
app.command()(symbols)
app.command("test")(run_tests)
app.command()(mutate)
