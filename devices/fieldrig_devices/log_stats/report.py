"""The statistics of a log for people, and as data."""

from typing import Any, Final

import typer

from fieldrig.cli.common import echo_table
from fieldrig.points.values import counted
from fieldrig.text.one_line import one_line
from fieldrig.traces.instants import instant, span
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_devices.log_stats.answers import Answers
from fieldrig_devices.log_stats.can_stats import CanStats, NodeStats
from fieldrig_devices.log_stats.log_stats import BusStats, LogStats, ModbusStats
from fieldrig_devices.log_stats.series import Series

MOST_ROWS: Final = 200
"""Rows of a table for people; scripts get all."""
MOST_ERRORS: Final = 4
"""Kinds of errors that a row names."""


def as_data(stats: LogStats) -> dict[str, Any]:
    """Return all figures, for JSON."""
    return {
        "count": stats.count,
        "first_ns": stats.first_ns,
        "last_ns": stats.last_ns,
        "duration_ns": stats.duration_ns,
        "bitrate": stats.bitrate,
        "is_bitrate_assumed": stats.is_assumed,
        "buses": [_bus_data(bus, stats) for bus in stats.buses.values()],
    }


def _bus_data(bus: BusStats, stats: LogStats) -> dict[str, Any]:
    found: dict[str, Any] = {
        "bus": bus.name,
        "family": bus.family,
        **bus.all.as_data(),
        "senders": {name: series.as_data() for name, series in bus.senders.items()},
    }
    if isinstance(bus.of_family, CanStats):
        found |= _can_data(bus.of_family, stats)
    elif isinstance(bus.of_family, ModbusStats):
        modbus = bus.of_family
        found["units"] = [
            {
                "unit": unit.unit,
                "server": unit.server,
                "name": modbus.names.unit(unit.unit).name,
                **unit.answers.as_data(),
                "requests": unit.requests.as_data(),
            }
            for _, unit in sorted(modbus.units.items())
        ]
    return found


def _can_data(can: CanStats, stats: LogStats) -> dict[str, Any]:
    return {
        "load": can.load.mean(stats.duration_ns),
        "load_by_second": [{"second": second, "load": load} for second, load in can.load.by_second()],
        "identifiers": [_identifier_data(can, key, series) for key, series in sorted(can.identifiers.items())],
        "other_identifiers": can.others,
        "nodes": [
            {"node_id": node_id, "name": can.names.name(node_id), **node.as_data()}
            for node_id, node in sorted(can.nodes.items())
        ],
        "errors": dict(can.errors.most_common()),
    }


def _identifier_data(can: CanStats, key: int, series: Series) -> dict[str, Any]:
    service, node = can.label(key)
    return {
        "identifier": key & ~EXTENDED,
        "is_extended": bool(key & EXTENDED),
        "service": service,
        "node": node,
        **series.as_data(),
    }


def show(stats: LogStats) -> None:
    """Print the figures as tables."""
    if not stats.count:
        typer.echo("no messages")
        return
    typer.echo(f"{counted(stats.count, 'message')} in {span(stats.duration_ns)}, from {instant(stats.first_ns)}")
    for bus in stats.buses.values():
        typer.echo("")
        typer.echo(f"{one_line(bus.name)} ({bus.family}): {counted(bus.all.count, 'message')}")
        if isinstance(bus.of_family, CanStats):
            _show_can(bus.of_family, stats)
        elif isinstance(bus.of_family, ModbusStats):
            _show_modbus(bus.of_family)
        else:
            _table(
                ("sender", "count", "period", "jitter"), [(name or "-", *_row(s)) for name, s in bus.senders.items()]
            )


def _show_can(can: CanStats, stats: LogStats) -> None:
    seconds = can.load.by_second()
    if seconds:
        peak, load = max(seconds, key=lambda second: second[1])
        assumed = " (assumed; --bitrate)" if stats.is_assumed else ""
        busiest = f"busiest second {load:.1%} at {instant(max(peak * 1_000_000_000, stats.first_ns))}"
        typer.echo(f"load {can.load.mean(stats.duration_ns):.1%} at {can.bitrate / 1000:g} kbit/s{assumed}, {busiest}")
    rows = []
    for key, series in sorted(can.identifiers.items()):
        identifier = f"{key & ~EXTENDED:08X}" if key & EXTENDED else f"{key:03X}"
        service, node = can.label(key)
        rows.append((identifier, service, node, *_row(series)))
    _table(("id", "service", "node", "count", "period", "jitter"), rows)
    if can.others:
        typer.echo(f"{counted(can.others, 'frame')} of further identifiers")
    nodes = [(can.names.name(node_id), *_node_row(node)) for node_id, node in sorted(can.nodes.items())]
    _table(("node", "frames", "boot-ups", "lost", "SDO", "no answer", "p50", "p99", "errors"), nodes)
    for words, count in can.errors.most_common():
        typer.echo(f"{count} x {words}")


def _node_row(node: NodeStats) -> tuple[object, ...]:
    emergencies = [f"EMCY {words} x {count}" for words, count in node.emergencies.most_common()]
    return (node.frames, node.boot_ups, node.losses, *_answers_row(node.sdo, emergencies))


def _answers_row(answers: Answers, more: list[str]) -> tuple[object, ...]:
    times = answers.times
    spread = (span(times.quantile(0.5)), span(times.quantile(0.99))) if times.count else ("", "")
    strays = [f"messages without a dialogue x {answers.strays}"] if answers.strays else []
    errors = [*(f"{words} x {count}" for words, count in answers.errors.most_common()), *strays, *more]
    if len(errors) > MOST_ERRORS + 1:
        errors[MOST_ERRORS:] = [f"{len(errors) - MOST_ERRORS} more kinds; --json has all"]
    return (answers.reads + answers.writes, answers.unanswered, *spread, "; ".join(errors))


def _show_modbus(modbus: ModbusStats) -> None:
    rows = []
    for _, unit in sorted(modbus.units.items()):
        name = modbus.names.unit(unit.unit).name
        words = f"{name} of {unit.server}" if unit.server else name
        rows.append((words, *_row(unit.requests)[1:], *_answers_row(unit.answers, [])))
    _table(("unit", "period", "jitter", "requests", "no answer", "p50", "p99", "errors"), rows)


def _row(series: Series) -> tuple[object, ...]:
    if not series.gaps.count:
        return series.count, "", ""
    return series.count, span(series.period_ns), span(series.jitter_ns)


def _table(headings: tuple[str, ...], rows: list[tuple[object, ...]]) -> None:
    if not rows:
        return
    typer.echo("")
    echo_table(headings, [[one_line(str(cell)) for cell in row] for row in rows[:MOST_ROWS]])
    if len(rows) > MOST_ROWS:
        typer.echo(f"... and {len(rows) - MOST_ROWS} more; --json has all")
