"""The command `fieldrig iec run`: a program alone, with its variables on the screen."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any, Final

import typer

from fieldrig.cli.common import AsJson, For, duration_ns, echo_json, echo_table
from fieldrig.exits import Exit
from fieldrig_devices.iec.commands.sources import DialectOption, Files, dialect_named, read_sources

if TYPE_CHECKING:
    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.iec.solo import Solo
    from fieldrig_devices.languages.debugging.debuggee import Variable

MOST_SHOWN: Final = 60
"""Lines of variables on the screen."""
_PERIOD_NS: Final = 100_000_000  # between two pictures on the screen, in real time


def run(
    files: Files,
    dialect: DialectOption = "epas-4",
    length: For = None,
    speed: Annotated[
        float, typer.Option("--speed", metavar="N", min=0.001, max=1e6, help="Seconds of the program per second.")
    ] = 1.0,
    watched: Annotated[
        list[str] | None,
        typer.Option("--watch", metavar="NAME", help="Show this variable, or those in it; may be repeated."),
    ] = None,
    settings: Annotated[
        list[str] | None,
        typer.Option("--set", metavar="NAME=VALUE", help="Give a variable this value at the start; may be repeated."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Run a program alone, without a rig, and show its variables.

    \b
        fieldrig iec run traffic-light.st
        fieldrig iec run tank.st --set PLC_PRG.level=40 --watch PLC_PRG.valve
        fieldrig iec run tank.st --for 10s --speed 100 --json

    On a terminal the variables are shown as they change, until Ctrl-C. Elsewhere they are printed once, at the end of
    --for. The exit code is 2 if the program does not compile, and 6 if a task was suspended by a fault.
    """
    limit_ns = None if length is None else duration_ns(length)
    solo = _started(files, dialect_named(dialect), settings or [])
    names = watched or []
    _shown(solo, names)  # a wrong name is wrong before anything runs
    try:
        _run(solo, names, speed, limit_ns, is_live=not as_json)
    except KeyboardInterrupt:
        typer.echo()
    variables = _shown(solo, names)
    if as_json:
        echo_json({variable.path: variable.value for variable in variables})
    else:
        echo_table(("variable", "type", "value"), [_row(variable) for variable in variables])
    for event in solo.events:
        typer.echo(event, err=True)
    if any("suspended" in event for event in solo.events):
        raise typer.Exit(Exit.REFUSED)


def _started(files: Any, dialect: "Dialect", settings: Sequence[str]) -> "Solo":
    """Compile the program, set its variables, and start it."""
    from fieldrig.clock import VirtualClock
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.solo import Solo
    from fieldrig_devices.iec.standalone import StandaloneHost
    from fieldrig_devices.languages.mistakes import CompileError

    clock = VirtualClock()
    host = StandaloneHost(clock)
    try:
        compiled = compile_project(read_sources(files), host, dialect)
    except CompileError as wrong:
        for mistake in wrong.mistakes:
            typer.echo(str(mistake), err=True)
        raise typer.Exit(Exit.WRONG) from wrong
    solo = Solo(clock, host, compiled)
    for setting in settings:
        name, sign, value = setting.partition("=")
        if not sign:
            raise typer.BadParameter(f"expected NAME=VALUE, got {setting!r}", param_hint="--set")
        try:
            solo.write(name.strip(), value.strip())
        except ValueError as cause:
            raise typer.BadParameter(str(cause), param_hint="--set") from cause
    solo.start()
    return solo


def _run(solo: "Solo", names: Sequence[str], speed: float, limit_ns: int | None, *, is_live: bool) -> None:
    """Run until the limit, Ctrl-C, or the end of all tasks by a fault."""
    from rich.console import Console
    from rich.live import Live

    from fieldrig.pacing import elapsed_ns

    console = Console(highlight=False, markup=False)
    if not is_live or not console.is_terminal:
        if limit_ns is None:
            raise typer.BadParameter("expected a time, because there is no terminal to stop at", param_hint="--for")
        solo.run_until(limit_ns)
        return
    with Live(console=console, auto_refresh=False, transient=True) as live:
        next_ns = 0
        for now_ns in elapsed_ns(speed, limit_ns):
            solo.run_until(now_ns)
            if solo.is_over:
                return
            if now_ns >= next_ns:
                next_ns = now_ns + round(_PERIOD_NS * speed)
                live.update(_picture(solo, names, now_ns), refresh=True)


def _picture(solo: "Solo", names: Sequence[str], now_ns: int) -> Any:
    from rich.table import Table

    table = Table("variable", "type", "value", box=None, pad_edge=False, title=f"{now_ns / 1e9:.1f} s; Ctrl-C ends it")
    variables = _shown(solo, names)
    for variable in variables[:MOST_SHOWN]:
        table.add_row(*_row(variable))
    if len(variables) > MOST_SHOWN:
        table.add_row(f"and {len(variables) - MOST_SHOWN} more; --watch NAME chooses", "", "")
    return table


def _row(variable: "Variable") -> tuple[str, str, str]:
    from fieldrig_devices.languages.debugging.adapter import text_of

    return variable.path, variable.type, "" if variable.value is None else text_of(variable.value)


def _shown(solo: "Solo", names: Sequence[str]) -> "list[Variable]":
    """Return the variables to show: those of a name, or all."""
    try:
        roots = [solo.evaluate(name) for name in names] if names else list(solo.variables(""))
    except ValueError as cause:
        raise typer.BadParameter(str(cause), param_hint="--watch") from cause
    return [leaf for root in roots for leaf in _leaves(solo, root)]


def _leaves(solo: "Solo", variable: "Variable") -> "Iterator[Variable]":
    children = solo.variables(variable.path) if variable.value is None else ()
    if not children:
        yield variable
    for child in children:
        yield from _leaves(solo, child)
