"""The commands of `fieldrig`, and what they share."""

from typing import Annotated

import typer

from fieldrig.cli import fault, points, rigfile, status, timing, trace, up, watch
from fieldrig.cli.common import CONTEXT
from fieldrig.cli.installed import Commands
from fieldrig.exits import ABOUT, Exit

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
A machine's electronics on the bench, without the machine.

A rig file (YAML) names buses and devices. `fieldrig up` runs them, on real buses and sockets, for your own master,
PLC program or service tool; the other commands look into a rig that runs.

\b
    fieldrig new lab                      make an example rig and its files in the folder lab
    fieldrig up lab/lab.yaml              start it; it prints how to reach each part
    fieldrig status                       what runs, and how it is
    fieldrig watch can0                   every message on a bus
    fieldrig get tank                     all values of a device
    fieldrig set drive/speed_set=50       change one
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
        bool, typer.Option("--version", help="Say which version this is.", callback=_show_version, is_eager=True)
    ] = False,
) -> None:
    """What stands in `help` above."""


app.command()(up.up)
app.command()(status.status)
app.command()(watch.watch)
app.command()(points.get)
app.command("set")(points.set_)
app.command()(fault.fault)
app.command()(timing.step)
app.command()(timing.pause)
app.command()(timing.run)
app.command()(timing.stop)
app.command()(timing.restart)
app.add_typer(trace.app, name="trace")
app.command()(rigfile.check)
app.command()(rigfile.devices)
app.command()(rigfile.schema)
