"""The commands of `fieldrig`, with the help of the whole."""

from typing import Annotated

import typer

from fieldrig.cli import coverage, exec, fault, help, points, record, rigfile, status, timing, trace, up, watch
from fieldrig.cli.common import CONTEXT
from fieldrig.cli.installed import Commands
from fieldrig.system.exits import ABOUT, Exit

_SHOWN = (
    Exit.OK,
    Exit.BUG,
    Exit.WRONG,
    Exit.CANNOT_START,
    Exit.NO_RIG,
    Exit.DEVICE_FAILED,
    Exit.REFUSED,
    Exit.NOT_READY,
    Exit.NOT_CONFORMING,
)

_ABOUT = """
Run a machine's electronics on your bench, without the machine.

A rig file (YAML) describes buses and devices. `fieldrig up` runs them on real buses and sockets, so that your own
master, PLC program or service tool can connect. The other commands inspect and control a running rig.

\b
    fieldrig new lab                      create an example rig in the folder lab
    fieldrig up lab/lab.yaml              start it, and print a line for each connection
    fieldrig help drive                   show how to reach a device, with commands to copy
    fieldrig status                       show the state of each process and bus
    fieldrig watch can0                   show every message on a bus
    fieldrig get tank                     show all values of a device
    fieldrig set drive/speed_set=50       change a value
"""


def _exit_codes() -> str:
    return "\b\nExit codes:\n" + "\n".join(f"    {code.value}  {ABOUT[code]}" for code in _SHOWN)


app = typer.Typer(
    cls=Commands,
    help=f"{_ABOUT}\n{_exit_codes()}",
    no_args_is_help=True,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings=dict(CONTEXT),
)


def _show_version(is_wanted: bool) -> None:
    if is_wanted:
        from importlib.metadata import version

        typer.echo(f"fieldrig {version('fieldrig')}")
        raise typer.Exit


@app.callback()
def fieldrig(
    is_version_wanted: Annotated[
        bool, typer.Option("--version", help="Show the version and exit.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """Do nothing; the help text is given to the application above."""


app.command()(up.up)
app.command("exec")(exec.exec_)
app.command("help")(help.help_)
app.command()(status.status)
app.command()(watch.watch)
app.command()(points.get)
app.command("set")(points.set_)
app.command()(fault.fault)
app.command()(timing.step)
app.command()(timing.back)
app.command()(timing.pause)
app.command()(timing.run)
app.command()(timing.stop)
app.command()(timing.restart)
app.command()(record.record)
app.command()(coverage.coverage)
app.add_typer(trace.app, name="trace")
app.command()(rigfile.check)
app.command()(rigfile.devices)
app.command()(rigfile.schema)
