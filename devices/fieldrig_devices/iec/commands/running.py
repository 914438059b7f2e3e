"""The command `fieldrig iec run`: a program alone, with its variables on the screen."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import typer

from fieldrig.cli.common import AsJson, For, duration_ns
from fieldrig.system.exits import Exit
from fieldrig_devices.iec.commands.sources import DialectOption, Files, ResourceOption, dialect_named, read_sources
from fieldrig_devices.languages.debugging.alone import Settings, Speed, Watched, run_and_show, set_all

if TYPE_CHECKING:
    from fieldrig_devices.iec.dialect import Dialect
    from fieldrig_devices.iec.solo import Solo


def run(
    files: Files,
    dialect: DialectOption = "epas-4",
    resource: ResourceOption = "",
    length: For = None,
    speed: Speed = 1.0,
    watched: Watched = None,
    settings: Settings = None,
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
    solo = _started(files, dialect_named(dialect), resource, settings or [])

    def is_failed() -> bool:
        return any("suspended" in event for event in solo.events)

    run_and_show(solo, watched or [], speed, limit_ns, as_json=as_json, is_failed=is_failed)


def _started(files: Any, dialect: "Dialect", resource: str, settings: Sequence[str]) -> "Solo":
    """Compile the program, set its variables, and start it."""
    from fieldrig.clock import VirtualClock
    from fieldrig.errors import UsageError
    from fieldrig_devices.iec.compiler import compile_project
    from fieldrig_devices.iec.solo import Solo
    from fieldrig_devices.iec.standalone import StandaloneHost
    from fieldrig_devices.languages.mistakes import CompileError

    clock = VirtualClock()
    host = StandaloneHost(clock)
    try:
        compiled = compile_project(read_sources(files), host, dialect, resource=resource)
    except CompileError as wrong:
        for mistake in wrong.mistakes:
            if not mistake.is_note:
                typer.echo(str(mistake), err=True)
        raise typer.Exit(Exit.WRONG) from wrong
    if not compiled.program.tasks:
        raise UsageError("there is no program to run", "expected PROGRAM name ... END_PROGRAM in the source")
    solo = Solo(clock, host, compiled)
    set_all(solo, settings)
    solo.start()
    return solo
