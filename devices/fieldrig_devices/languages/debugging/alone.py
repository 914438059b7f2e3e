"""Run a program alone, without a rig, with its variables on the screen, as `fieldrig iec run` does."""

from collections.abc import Callable, Iterator, Sequence
from typing import Annotated, Any, Final, Protocol

import typer

from fieldrig.cli.common import echo_json, echo_table
from fieldrig.device import Value
from fieldrig.system.exits import Exit
from fieldrig_devices.languages.debugging.debuggee import Variable

MOST_SHOWN: Final = 60
"""Lines of variables on the screen."""
_PERIOD_NS: Final = 100_000_000  # between two pictures on the screen, in real time

Speed = Annotated[
    float, typer.Option("--speed", metavar="N", min=0.001, max=1e6, help="Seconds of the program per second.")
]
Watched = Annotated[
    list[str] | None,
    typer.Option("--watch", metavar="NAME", help="Show this variable, or those in it; may be repeated."),
]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="NAME=VALUE", help="Give a variable this value at the start; may be repeated."),
]


class Alone(Protocol):
    """A program that runs alone, on a clock of its own."""

    events: list[str]
    """Faults and other events, in whole sentences."""

    @property
    def is_over(self) -> bool:
        """True if the program has ended by an error."""

    def run_until(self, time_ns: int) -> None: ...

    def variables(self, path: str) -> Sequence[Variable]: ...

    def evaluate(self, text: str) -> Variable: ...

    def write(self, path: str, value: Value) -> None: ...


def set_all(program: Alone, settings: Sequence[str]) -> None:
    """Give variables their values, as in NAME=VALUE."""
    for setting in settings:
        name, sign, value = setting.partition("=")
        if not sign:
            raise typer.BadParameter(f"expected NAME=VALUE, got {setting!r}", param_hint="--set")
        try:
            program.write(name.strip(), value.strip())
        except ValueError as cause:
            raise typer.BadParameter(str(cause), param_hint="--set") from cause


def run_and_show(
    program: Alone,
    names: Sequence[str],
    speed: float,
    limit_ns: int | None,
    *,
    as_json: bool,
    is_failed: Callable[[], bool],
) -> None:
    """Run a program and show its variables; exit with code 6 if `is_failed` says so at the end."""
    shown(program, names)  # a wrong name is wrong before anything runs
    try:
        _run(program, names, speed, limit_ns, is_live=not as_json)
    except KeyboardInterrupt:
        typer.echo()
    variables = shown(program, names)
    if as_json:
        echo_json({variable.path: variable.value for variable in variables})
    else:
        echo_table(("variable", "type", "value"), [_row(variable) for variable in variables])
    for event in program.events:
        typer.echo(event, err=True)
    if is_failed():
        raise typer.Exit(Exit.REFUSED)


def _run(program: Alone, names: Sequence[str], speed: float, limit_ns: int | None, *, is_live: bool) -> None:
    """Run until the limit, Ctrl-C, or the end of the program by a fault."""
    from rich.console import Console
    from rich.live import Live

    from fieldrig.loop.pacing import elapsed_ns

    console = Console(highlight=False, markup=False)
    if not is_live or not console.is_terminal:
        if limit_ns is None:
            raise typer.BadParameter("expected a time, because there is no terminal to stop at", param_hint="--for")
        program.run_until(limit_ns)
        return
    with Live(console=console, auto_refresh=False, transient=True) as live:
        next_ns = 0
        for now_ns in elapsed_ns(speed, limit_ns):
            program.run_until(now_ns)
            if program.is_over:
                return
            if now_ns >= next_ns:
                next_ns = now_ns + round(_PERIOD_NS * speed)
                live.update(_picture(program, names, now_ns), refresh=True)


def _picture(program: Alone, names: Sequence[str], now_ns: int) -> Any:
    from rich.table import Table

    table = Table("variable", "type", "value", box=None, pad_edge=False, title=f"{now_ns / 1e9:.1f} s; Ctrl-C ends it")
    variables = shown(program, names)
    for variable in variables[:MOST_SHOWN]:
        table.add_row(*_row(variable))
    if len(variables) > MOST_SHOWN:
        table.add_row(f"and {len(variables) - MOST_SHOWN} more; --watch NAME chooses", "", "")
    return table


def _row(variable: Variable) -> tuple[str, str, str]:
    from fieldrig_devices.languages.debugging.texts import text_of

    return variable.path, variable.type, variable.text or text_of(variable.value)


def shown(program: Alone, names: Sequence[str]) -> list[Variable]:
    """Return the variables to show: those of a name, or all."""
    try:
        roots = [program.evaluate(name) for name in names] if names else list(program.variables(""))
    except ValueError as cause:
        raise typer.BadParameter(str(cause), param_hint="--watch") from cause
    return [leaf for root in roots for leaf in _leaves(program, root)]


def _leaves(program: Alone, variable: Variable) -> Iterator[Variable]:
    children = program.variables(variable.path) if variable.value is None else ()
    if not children:
        yield variable
    for child in children:
        yield from _leaves(program, child)
