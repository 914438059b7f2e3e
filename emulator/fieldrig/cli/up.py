"""The command `up`: start a rig, and run it until it ends."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli import covering
from fieldrig.cli.common import ListenAt, Overrides, RigFile, WithoutPage
from fieldrig.system.exits import Exit
from fieldrig.system.own_files import OUTSIDE_VARIABLE

if TYPE_CHECKING:
    from fieldrig.config.rig_file import RigConfig


def up(
    context: typer.Context,
    file: RigFile,
    overrides: Overrides = None,
    only: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Run only this process, device or bus of a rig in real time. Its control service runs elsewhere.",
            show_default=False,
        ),
    ] = None,
    control_only: Annotated[
        bool,
        typer.Option(
            "--control-only", help="Run only the control service. The processes are started elsewhere, with --only."
        ),
    ] = False,
    trace: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE", help="Record every message in a file, as `fieldrig trace record` does.", show_default=False
        ),
    ] = None,
    control: ListenAt = None,
    realtime: Annotated[
        bool,
        typer.Option("--realtime", help="Request SCHED_FIFO scheduling for every process. Needs root or CAP_SYS_NICE."),
    ] = False,
    outside_paths: Annotated[
        bool,
        typer.Option(
            "--outside-paths",
            envvar=OUTSIDE_VARIABLE,
            help="Allow paths of the rig file that leave its run folder, such as the pty of a serial line in /dev.",
        ),
    ] = False,
    no_ui: WithoutPage = False,
    is_covered: covering.Shown = False,
    is_detailed: covering.Detail = False,
    data: covering.Data = None,
    lcov: covering.Lcov = None,
    cobertura: covering.Cobertura = None,
    page: covering.Page = None,
    least: covering.Least = None,
    quiet: Annotated[
        bool,
        typer.Option("--quiet", "-q", help="Print only problems: processes that fail, die or restart, and warnings."),
    ] = False,
) -> None:
    """Start a rig and run it until Ctrl-C.

    Print a line for each connection, and report what happens.  `fieldrig help NAME` shows how to use one.

    \b
        fieldrig up configs/lab.yaml
        fieldrig up configs/lab.yaml --set buses.can0.bitrate=250000
        fieldrig up configs/lab.yaml --trace lab.pcapng
        fieldrig up configs/feeder.yaml --coverage-html build/coverage
    To run each part in a container of its own:
        fieldrig up lab.yaml --control-only
        fieldrig up lab.yaml --only io

    With `time: real`, every device runs in a process of its own. The logs are in the folder log/ of the rig's run
    folder; set FIELDRIG_LOG=DEBUG for more detail. Ctrl-C ends the rig in order; a second Ctrl-C ends it at once.
    """
    if only is not None and (control_only or trace is not None):
        raise typer.BadParameter("--only goes with neither --control-only nor --trace")
    if outside_paths:
        os.environ[OUTSIDE_VARIABLE] = "1"  # for the processes of the rig as well
    from fieldrig.config.rig_file import load, load_part
    from fieldrig.traces.formats import format_of

    values = _values(overrides or (), control, _is_from_environment(context, "control"))
    config = load(file, values) if only is None else load_part(file, values, only)
    if (only is not None or control_only) and config.time == "virtual":
        raise typer.BadParameter("a rig with time: virtual runs as a whole")
    if trace is not None:
        format_of(trace)
    with covering.Covering(is_covered, is_detailed, data, lcov, cobertura, page, least) as covered:
        if only is not None:
            code = _run_only(config, only, realtime)
        else:
            from fieldrig.cli.running import UpOptions, run_rig

            code = run_rig(config, UpOptions(values, trace, control_only, realtime, quiet, not no_ui))
        if not covered.report() and code is Exit.OK:
            code = Exit.TESTS_FAILED
    raise typer.Exit(code)


def _values(overrides: Sequence[str], control: str | None, is_from_environment: bool) -> list[str]:
    """Return everything that overrides the rig file.  The last one wins, and an option wins over a variable."""
    endpoint = [] if control is None else [f"control={control}"]
    return [*endpoint, *overrides] if is_from_environment else [*overrides, *endpoint]


def _is_from_environment(context: typer.Context, parameter: str) -> bool:
    source = context.get_parameter_source(parameter)
    return source is not None and source.name == "ENVIRONMENT"  # by name: typer may have a click of its own


def _run_only(config: "RigConfig", name: str, is_realtime: bool) -> Exit:
    from fieldrig.real.host import run_process, start_log
    from fieldrig.real.placement import placement, sockets
    from fieldrig.real.this_system import check_system
    from fieldrig.system.run_folder import check_length
    from fieldrig.text.nearest import closest

    check_system()
    plans = placement(config)
    plan = next((plan for plan in plans.values() if name in (plan.name, *plan.buses, *plan.devices)), None)
    if plan is None:
        parts = dict.fromkeys(part for plan in plans.values() for part in (plan.name, *plan.buses, *plan.devices))
        raise typer.BadParameter(f"this rig has no process, device or bus {name!r}; {closest(name, list(parts))}")
    check_length(config.run, sockets(config))
    start_log()
    return run_process(config, plan, is_supervised=False, is_realtime=is_realtime)
