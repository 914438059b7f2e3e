"""The command `status`: what runs, and in which state it is."""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from fieldrig.cli import completion
from fieldrig.cli.common import AsJson, Endpoint, echo_json, echo_table
from fieldrig.cli.names import check_name
from fieldrig.clock import MS
from fieldrig.outside.addresses import DEFAULT_ENDPOINT
from fieldrig.system.exits import Exit
from fieldrig.system.host_lateness import LATE_NS
from fieldrig.text.listed import listed

if TYPE_CHECKING:
    from fieldrig.control.messages import Client

HUNG_S = 1.0
"""Time limit for an answer, in seconds; a process that takes longer is shown without its figures."""

MOST_OF_PARTS = 60
"""Characters of the names of a process' buses and devices."""


def status(
    ready: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="Print nothing, and exit with 0 if this process, device or bus is ready, else with 7. Use `all`"
            " for the whole rig and `rig` for its control service.",
            show_default=False,
            autocompletion=completion.ready_part,
        ),
    ] = None,
    as_json: AsJson = False,
    endpoint: Endpoint = DEFAULT_ENDPOINT,
) -> None:
    """Show the processes, devices and buses of a running rig.

    \b
        fieldrig status
        fieldrig status --json
        fieldrig status --ready io && echo ready     for scripts and health checks
    """
    from fieldrig.control.messages import Client
    from fieldrig.control.rig_status import joined

    with Client(endpoint) as client:
        rig = client.ask("rig/status")
        if ready is not None:
            _check_name(rig, ready)
            raise typer.Exit(Exit.OK if _is_ready(rig, ready) else Exit.NOT_READY)
        details = client.ask_all("process/*/status", timeout_s=HUNG_S)
        page = _page(client) if "ui" in rig else {}
    rig = joined(rig, details, page)
    if as_json:
        echo_json(rig)
    else:
        _show(rig)


def _page(client: "Client") -> dict[str, Any]:
    """Return the figures of the page's process; none if it does not answer."""
    from fieldrig.errors import ControlError

    try:
        figures: dict[str, Any] = client.ask("ui/status", timeout_s=HUNG_S)
    except ControlError:
        return {}
    return figures


def _check_name(rig: dict[str, Any], name: str) -> None:
    """ControlError, with the closest names, if the rig has no such part."""
    known = [*rig["processes"], *rig["devices"], *rig["buses"], "all", "rig"]
    check_name(name, known, f"{rig['rig']} has no process, device or bus")


def _is_ready(rig: dict[str, Any], name: str) -> bool:
    if name == "rig":
        return True
    if name == "all":
        return bool(rig["state"] == "ready")
    if rig["time"] == "virtual":
        return name in rig["processes"] or name in rig["devices"] or name in rig["buses"]
    return any(
        process["state"] == "ready"
        for process_name, process in rig["processes"].items()
        if name == process_name or name in process["devices"] or name in process["buses"]
    )


def _show(rig: dict[str, Any]) -> None:
    time = f", at {rig['now_ns'] / 1e9:.6f} s of its time" if rig["time"] == "virtual" else ""
    typer.echo(f"{rig['rig']}: {rig['state']}, up for {_duration(rig['uptime_s'])}, time: {rig['time']}{time}")
    typer.echo(rig["file"])
    for device, trouble in rig.get("stores", {}).items():
        typer.echo(f"{device} cannot store anything: {trouble}; see its log in {rig['run']}/log")
    for process, limits in rig.get("limits", {}).items():
        typer.echo(f"limits that tools have reached at {process}: {_figures(limits)}")
    for device, limits in rig.get("client_limits", {}).items():
        typer.echo(f"limits that clients have reached at {device}: {_figures(limits)}")
    if silent := rig.get("silent_connections"):
        typer.echo(f"connections at the control endpoint that have said nothing yet: {silent}")
    for line in _lateness(rig):
        typer.echo(line)
    typer.echo()
    echo_table(
        ("process", "state", "pid", "up for", "restarts", "MB", "MB own", "CPU s", "runs"),
        [
            (
                name,
                _state(process),
                process["pid"],
                _duration(process["uptime_s"]) if process["uptime_s"] is not None else None,
                process["restarts"],
                process.get("memory_mb"),
                process.get("own_mb"),
                process.get("cpu_s"),
                _parts(process, rig),
            )
            for name, process in rig["processes"].items()
        ]
        + ([_page_row(rig["ui"])] if "ui" in rig else []),
    )
    typer.echo()
    echo_table(
        ("bus", "kind", ""),
        [(name, bus["kind"], _figures(bus.get("statistics", {}))) for name, bus in rig["buses"].items()],
    )


def _parts(process: dict[str, Any], rig: dict[str, Any]) -> str:
    """Return the buses and devices of a process, shortened; the JSON has all of them."""
    return listed([*process.get("buses", ()), *process.get("devices", rig["devices"])], MOST_OF_PARTS)


def _state(process: dict[str, Any]) -> str:
    """Return the state of a process for people: it may be stopped or hang although its start is complete."""
    state: str = process["state"]
    return "no answer" if state == "ready" and "cpu_s" not in process else state


def _page_row(page: dict[str, Any]) -> tuple[object, ...]:
    """Return the row of the page's process, in the columns of the others."""
    age = _duration(page["uptime_s"]) if "uptime_s" in page else None
    figures = (page.get(key) for key in ("memory_mb", "own_mb", "cpu_s"))
    return ("ui", page["state"], page["pid"], age, page["restarts"], *figures, f"the page at {page['address']}")


def _lateness(rig: dict[str, Any]) -> Iterator[str]:
    """Yield a line for each process that the host makes late, and one for the worst time so far."""
    for name, words in rig.get("late", {}).items():
        yield f"the host is late for {name}: {words}"
    for process in rig["processes"].values():
        for point, words in process.get("troubles", {}).items():
            yield f"{point} reports a fault; {words}"
    late = [(process["late"]["worst_ms"], name) for name, process in rig["processes"].items() if "late" in process]
    worst_ms, name = max(late, default=(0.0, ""))
    if worst_ms >= LATE_NS / MS:
        at = time.strftime("%H:%M:%S", time.localtime(rig["processes"][name]["late"]["worst_at_s"]))
        yield f"at {at} it was {worst_ms:,.0f} ms late for {name}; a fault of a device at that time may be the host's"


def _figures(statistics: dict[str, float]) -> str:
    """Return the counters in a line; the JSON has all of them, also of single members (`io.tec`)."""
    return ", ".join(f"{key} {_figure(value)}" for key, value in statistics.items() if value and "." not in key)


def _figure(value: float) -> str:
    """Return a counter with all its digits."""
    return str(int(value)) if float(value).is_integer() else f"{value:g}"


def _duration(seconds: float) -> str:
    whole = int(seconds)
    if whole < 60:
        return f"{seconds:.1f} s"
    hours, minutes = divmod(whole // 60, 60)
    return f"{hours} h {minutes:02} min" if hours else f"{minutes} min {whole % 60:02} s"
