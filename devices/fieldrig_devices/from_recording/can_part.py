"""A CAN bus of a recording as a part of a rig file, with its EDS files and recorded values."""

from collections.abc import Iterable, Iterator, Sequence
from math import ceil
from pathlib import Path, PurePosixPath

from fieldrig.text.flow import flow
from fieldrig_devices.from_recording.bit_rate import USUAL
from fieldrig_devices.from_recording.can_log import CanLog
from fieldrig_devices.from_recording.canopen_bus import CanopenBus
from fieldrig_devices.from_recording.columns import TIME, csv_of
from fieldrig_devices.from_recording.known_files import KnownFile
from fieldrig_devices.from_recording.node_model import NodeModel
from fieldrig_devices.from_recording.node_words import seen, unknown
from fieldrig_devices.from_recording.parts import RigPart, comment, unknown_lines
from fieldrig_devices.from_recording.read_backs import sdo_read_backs

FIRST_PORT = 29_536
MOST_PROCESSES = 8
"""Devices that have a process each; a host has few cores."""


def can_part(
    name: str, log: CanLog, source: str, prefix: str, folder: Path, files: Iterable[KnownFile], place: int
) -> RigPart:
    """Return the part for a bus; `place` numbers the buses, `prefix` begins the names of the devices."""
    bus = CanopenBus(log, source, prefix, folder, files)
    part = RigPart(name, is_can=True, nodes=[model.node_id for model in bus.nodes], described=bus.described)
    part.buses = _bus(name, log, bus.remarks, place)
    end_ns = log.end_ns
    shares = len(bus.nodes) > MOST_PROCESSES
    for model in bus.nodes:
        path, data = PurePosixPath("eds", model.eds.name), model.eds.read_bytes()
        if part.files.get(path, data) != data:  # makers call many files the same
            path = path.with_name(f"{model.name}-{model.eds.name}")
        part.files[path] = data
        recorded = PurePosixPath("recorded", f"{model.name}.csv")
        if model.columns:
            part.files[recorded], cut_ns = csv_of(model.columns, end_ns - model.begin_ns)
            if cut_ns is not None:
                model.remarks.append(f"values after {cut_ns / 1e9:.3f} s, because {recorded} would be too long")
        part.devices += _device(name, model, path, recorded, log.start_ns, shares)
        part.read_backs += sdo_read_backs(name, model)
    part.booted_s = 1 + ceil(max((model.boot_up_ms for model in bus.nodes), default=0) / 1_000)
    part.remarks = [f"{name}: {remark}" for remark in bus.remarks]
    return part


def _bus(name: str, log: CanLog, remarks: Sequence[str], place: int) -> list[str]:
    rate = log.bit_rate.found
    why = "as frames that follow each other show" if rate else "the recording does not show it: set that of your bus"
    return [
        *(line for remark in remarks for line in comment(remark, 2)),
        f"  {name}:",
        "    kind: can.hub",
        f"    bitrate: {rate or USUAL}  # {why}",
        f"    socketcand: 127.0.0.1:{FIRST_PORT + place}",
    ]


def _device(
    bus: str, model: NodeModel, eds: PurePosixPath, recorded: PurePosixPath, start_ns: int, shares: bool
) -> Iterator[str]:
    yield ""
    for sentence in seen(model, start_ns):
        yield from comment(sentence, 2)
    yield from unknown_lines(unknown(model))
    yield f"  {model.name}:"
    yield f"    kind: {'cia402.drive' if model.is_drive else 'canopen.node'}"
    yield f"    node_id: {model.node_id}"
    yield f"    eds: {flow(str(eds))}"
    yield f"    links: {{can: {bus}}}"
    if shares:
        yield f"    process: {bus}  # that of the bus, as there are many devices"
    for key, value in model.more.items():
        yield f"    {key}: {_behaviour(value) if key == 'behaviour' else flow(value)}"
    if model.objects:
        yield "    objects:"
        yield from (f"      {_key(key)}: {flow(value)}" for key, value in model.objects.items())
    if model.columns:
        yield "    sources:"
        for key in model.columns:
            source = {"kind": "replay", "file": str(recorded), "column": key, "time_column": TIME}
            yield f"      {_key(key)}: {flow(source)}"
    if model.faults:
        yield "    faults:"
        for fault in model.faults:
            yield f"      - {_fault(fault)}"


def _behaviour(keys: dict[str, object]) -> str:
    """Return the keys of a drive's behaviour, with indices as everyone writes them."""
    plain = {key: value for key, value in keys.items() if key != "missing"}
    indices = keys.get("missing")
    words = [f"{key}: {flow(value)}" for key, value in plain.items()]
    if isinstance(indices, list):
        words.append(f"missing: [{', '.join(f'0x{index:04X}' for index in indices)}]")
    return f"{{{', '.join(words)}}}"


def _key(key: str) -> str:
    return f'"{key}"'


def _fault(fault: dict[str, object]) -> str:
    words = {"index": "0x{:04X}", "code": "0x{:08X}" if fault["what"] == "sdo_abort" else "0x{:04X}"}
    return (
        "{"
        + ", ".join(
            f"{key}: {words[key].format(value) if key in words else flow(value)}" for key, value in fault.items()
        )
        + "}"
    )
