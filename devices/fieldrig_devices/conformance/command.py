"""`fieldrig conform`: tests a CANopen node, and reports the results."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from fieldrig.cli.common import AsJson, Overrides, echo_json, writing
from fieldrig.errors import BusError, UsageError
from fieldrig.system.exits import Exit

if TYPE_CHECKING:
    from fieldrig.config.entries import DeviceEntry
    from fieldrig.config.rig_file import RigConfig
    from fieldrig_devices.canopen.described import DescribedNode
    from fieldrig_devices.conformance.case import Case
    from fieldrig_devices.conformance.description import Description
    from fieldrig_devices.conformance.options import Options
    from fieldrig_devices.conformance.report import Report
    from fieldrig_devices.conformance.run import OnResult

_FILE = {"metavar": "FILE", "show_default": False}

BusName = Annotated[
    str | None,
    typer.Option(
        "--bus",
        metavar="BUS",
        help="can.socketcan:vcan0, can.udp:GROUP:PORT, can.hub:RUNFOLDER/can0, python-can:interface=...,channel=...;"
        " with --rig, the name of a bus of the rig.  [default: with --rig, that of its only node]",
        show_default=False,
    ),
]
RigFile = Annotated[
    Path | None, typer.Option("--rig", help="The file of a running rig, or of a rig with time: virtual.", **_FILE)
]
NodeId = Annotated[
    int | None,
    typer.Option(
        "--node",
        min=1,
        max=127,
        help="Node-ID of the node, 1 to 127.  [default: with --rig, that of its only node]",
        show_default=False,
    ),
]
Eds = Annotated[
    Path | None,
    typer.Option("--eds", help="EDS or DCF file of the node.  [default: with --rig, that of the device]", **_FILE),
]
Only = Annotated[
    list[str] | None,
    typer.Option(
        "--only",
        metavar="PATTERN",
        help="Run only these cases, by number, name or family: 2.7, 'PDO 2*', Guarding. May be given several times.",
        show_default=False,
    ),
]
Junit = Annotated[Path | None, typer.Option("--junit", help="Write a JUnit report.", **_FILE)]
Html = Annotated[Path | None, typer.Option("--html", help="Write an HTML report.", **_FILE)]
Markdown = Annotated[Path | None, typer.Option("--markdown", help="Write a Markdown report.", **_FILE)]
Timeout = Annotated[
    int, typer.Option("--timeout-ms", min=1, help="Time limit for an answer in ms; other limits scale with it.")
]
NoStore = Annotated[bool, typer.Option("--no-store", help="Skip the cases that write the node's non-volatile memory.")]
Alone = Annotated[
    bool, typer.Option("--alone", help="Also test NMT commands to all nodes; no other node may be on the bus.")
]
WithMasters = Annotated[
    bool,
    typer.Option(
        "--with-masters",
        help="With --rig: leave the rig's own masters of the node at work, whose commands may fail cases."
        "  [default: their commands are dropped]",
    ),
]
ListOnly = Annotated[bool, typer.Option("--list", help="List the cases with their requirements, and exit.")]


def conform(
    bus: BusName = None,
    node_id: NodeId = None,
    eds: Eds = None,
    rig: RigFile = None,
    overrides: Overrides = None,
    only: Only = None,
    junit: Junit = None,
    html: Html = None,
    markdown: Markdown = None,
    timeout_ms: Timeout = 500,
    no_store: NoStore = False,
    alone: Alone = False,
    with_masters: WithMasters = False,
    list_only: ListOnly = False,
    as_json: AsJson = False,
) -> None:
    """Test a CANopen node for conformance to CiA 301.

    \b
    Run 127 named cases; each reports its requirement, the frames seen and a verdict. The suite restores what it changes
    in the node. It resets, starts and stops the node, so never run it on a machine that can move.
        fieldrig conform --bus can.socketcan:vcan0 --node 5 --eds io32.eds
        fieldrig conform --rig configs/lab.yaml --bus can0 --node 5       a node of a running rig
        fieldrig conform --rig configs/lab.yaml --set time=virtual --bus can0 --node 5      in virtual time
        fieldrig conform --bus can.hub:run/lab/can0 --node 5 --eds io32.eds --only 'SDO*' --html out.html
    The exit code is 0 if no case failed, and 8 otherwise.
    """
    from fieldrig_devices.conformance.options import Options
    from fieldrig_devices.conformance.report import as_data
    from fieldrig_devices.conformance.run import choose
    from fieldrig_devices.conformance.suite import Verdict
    from fieldrig_devices.conformance.terminal import console, show_report, show_result

    cases = choose(only or ())
    if list_only:
        _list(cases, as_json)
        return
    config = _config(rig, overrides or ())
    if config is not None:
        bus, node_id = _only_node(config, bus, node_id)
    missing = [option for option, value in (("--bus", bus), ("--node", node_id)) if value is None]
    if bus is None or node_id is None:
        raise typer.BadParameter(f"{' and '.join(missing)} missing; expected --bus and --node, and --eds or --rig")
    out = console()
    options = Options(timeout_ms, timeout_ms * 10, not no_store, alone)
    report = _report(
        bus,
        node_id,
        eds,
        config,
        with_masters,
        cases,
        options,
        None if as_json else lambda result: show_result(out, result),
    )
    _write(report, junit, html, markdown)
    if as_json:
        echo_json(as_data(report))
    else:
        show_report(out, report)
    raise typer.Exit(Exit.NOT_CONFORMING if report.count(Verdict.FAILED) else Exit.OK)


def _report(
    bus: str,
    node_id: int,
    eds: Path | None,
    config: "RigConfig | None",
    with_masters: bool,
    cases: "list[Case]",
    options: "Options",
    on_result: "OnResult | None",
) -> "Report":
    from contextlib import ExitStack
    from datetime import UTC, datetime
    from functools import partial

    from fieldrig.text.nearest import closest
    from fieldrig.virtual.rig import Rig
    from fieldrig_devices.conformance import address
    from fieldrig_devices.conformance.description import Description
    from fieldrig_devices.conformance.other_masters import kept_off, masters_of
    from fieldrig_devices.conformance.run import conform_real, conform_virtual

    date = datetime.now(UTC).date().isoformat()
    if config is None:
        where = address.parse(bus)
        if eds is None:
            raise typer.BadParameter("expected --eds FILE, the EDS or DCF file of the node, or --rig FILE")
        description = Description(eds, node_id)
        return conform_real(where.bus, where.run, description, cases, options, on_result, date, bus, _tell)
    if bus not in config.buses:
        raise UsageError(f"{config.name} has no bus {bus!r}", closest(bus, list(config.buses)))
    description = _described(config, bus, node_id, eds)
    masters = masters_of(config, bus, node_id)
    for master in masters:
        how = "what it sends may fail cases" if with_masters else "its commands are dropped during the run"
        typer.echo(f"note: {master} is the master of node {node_id} in this rig; {how}", err=True)
    kept = [] if with_masters else masters
    if config.time == "virtual":
        with (
            Rig(config) as running,
            kept_off(kept, node_id, partial(running.add_fault, bus), partial(running.clear_fault, bus)),
        ):
            return conform_virtual(running, bus, description, cases, options, on_result, date, _tell)
    where_text = f"{bus} of {config.name}"
    own = config.buses[bus].bus
    with ExitStack() as opened:
        if kept:
            from fieldrig.real.running_rig import RunningRig  # a rig in virtual time needs no process

            live = opened.enter_context(RunningRig(config.control))
            opened.enter_context(kept_off(kept, node_id, partial(live.add_fault, bus), partial(live.clear_fault, bus)))
        try:
            return conform_real(
                own, config.run.absolute(), description, cases, options, on_result, date, where_text, _tell
            )
        except BusError as cause:
            remedy = "start it by `fieldrig up`, or test the node in virtual time by --set time=virtual"
            raise BusError(f"{config.name} does not run here: {cause.what}", remedy) from cause


def _tell(progress: str) -> None:
    typer.echo(f"... {progress}", err=True)


def _config(rig: Path | None, overrides: Sequence[str]) -> "RigConfig | None":
    from fieldrig.config.rig_file import load

    return None if rig is None else load(rig, overrides)


def _only_node(config: "RigConfig", bus: str | None, node_id: int | None) -> tuple[str, int]:
    """Return bus and node-ID of the node that is meant.  UsageError if the rig has several such nodes, or none."""
    from fieldrig_bus.can.family import CanFamily

    if bus is not None and node_id is not None:
        return bus, node_id
    nodes = {
        (name, node.node_id): device.name
        for name, entry in config.buses.items()
        if isinstance(entry.bus, CanFamily)
        for device in config.devices.values()
        for node in _nodes_at(device, name)
        if node.node_id is not None
    }
    found = [(name, number) for name, number in nodes if bus in (None, name) and node_id in (None, number)]
    if not nodes:
        raise UsageError(f"{config.name} has no CANopen node of its own", "name --bus, --node and --eds FILE")
    if len(found) != 1:
        choices = [f"--bus {name} --node {number} ({nodes[name, number]})" for name, number in found or nodes]
        raise UsageError(
            f"{config.name} has {'several CANopen nodes' if found else 'no such CANopen node'}",
            f"expected one of {', '.join(choices)}",
        )
    return found[0]


def _described(config: "RigConfig", bus: str, node_id: int, eds: Path | None) -> "Description":
    """Return the node's EDS, with the power-on values of the rig file (`objects`) laid over it, as those of a DCF."""
    from fieldrig_devices.conformance.description import Description

    nodes = [node for device in config.devices.values() for node in _nodes_at(device, bus)]
    found = next((node for node in nodes if node.node_id == node_id), None)
    path = eds or (found.eds if found is not None else None)
    if path is None:
        known = ", ".join(str(node.node_id) for node in nodes if node.eds is not None)
        raise UsageError(
            f"no device of {config.name} on {bus} has node-ID {node_id} and an EDS",
            f"{f'there are {known}; ' if known else ''}for another one, name the file with --eds FILE",
        )
    description = Description(path, node_id)
    if found is not None and eds is None:
        for key, value in found.objects.items():
            description.set_default(key, value)
    return description


def _nodes_at(device: "DeviceEntry", bus: str) -> "Iterator[DescribedNode]":
    """Yield the CANopen nodes of a device on this bus."""
    from fieldrig_devices.canopen.described import nodes_of

    if any(bus in buses for buses in device.links.values()):
        yield from nodes_of(device.settings)


def _write(report: "Report", junit: Path | None, html: Path | None, markdown: Path | None) -> None:
    from fieldrig_devices.conformance.report_files import to_html, to_junit, to_markdown

    for path, make in ((junit, to_junit), (html, to_html), (markdown, to_markdown)):
        if path is not None:
            with writing(path):
                path.write_text(make(report), encoding="utf-8")


def _list(cases: "list[Case]", as_json: bool) -> None:
    if as_json:
        echo_json(
            [
                {"number": case.number, "name": case.name, "requirement": case.requirement, "clause": case.clause}
                for case in cases
            ]
        )
        return
    for case in cases:
        typer.echo(f"{case.number:>6} {case.name:30} {case.requirement} ({case.clause})")
