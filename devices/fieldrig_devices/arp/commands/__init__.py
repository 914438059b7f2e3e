"""`fieldrig arp`: commands for programs of the ARP card, and for cards at their USER port."""

from fieldrig.cli.common import command_group
from fieldrig_devices.arp.commands import parameters, values
from fieldrig_devices.arp.commands.checking import check
from fieldrig_devices.arp.commands.compiling import compile_
from fieldrig_devices.arp.commands.debugging import debug
from fieldrig_devices.arp.commands.formatting import fmt
from fieldrig_devices.arp.commands.program import download, reset, run, state, stop, upload

SECTION = "Programs"
"""The group of the command in the help of `fieldrig`."""
app = command_group()


@app.callback()
def arp() -> None:
    """Compile, load and debug programs of ARP two-axis cards.

    \b
    All commands but check, compile and fmt connect to a card; give its USER port by --port, FIELDRIG_ARP_PORT or --rig:
        fieldrig arp download cam.I01 --port /dev/ttyUSB0
        fieldrig arp state --port socket://127.0.0.1:7011
        fieldrig arp debug cam.I01 --rig arp-cell.yaml --card card1
    """


app.command()(check)
app.command()(fmt)
app.command("compile")(compile_)
app.command()(download)
app.command()(upload)
app.command()(run)
app.command()(stop)
app.command()(reset)
app.command()(state)
app.command()(values.get)
app.command("set")(values.set_)
app.command()(values.watch)
app.add_typer(parameters.app, name="params")
app.command()(debug)
