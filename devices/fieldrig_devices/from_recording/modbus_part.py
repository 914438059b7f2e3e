"""A Modbus bus of a recording as a part of a rig file, with its register tables and recorded values."""

from collections.abc import Iterator
from pathlib import PurePosixPath
from typing import Final

from fieldrig.points.values import counted
from fieldrig.text.flow import flow
from fieldrig.text.ranges import ranges
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.serial.message import Format
from fieldrig_devices.from_recording.bus_words import never_answered
from fieldrig_devices.from_recording.columns import csv_of
from fieldrig_devices.from_recording.line_rate import LineRate, Rate
from fieldrig_devices.from_recording.modbus_log import ModbusLog, UnitLog
from fieldrig_devices.from_recording.modbus_unit import UnitModel
from fieldrig_devices.from_recording.parts import RigPart, comment, unknown_lines

FIRST_PORT: Final = 5_020
UNIT_IDS: Final = range(1, 248)
DEVICE_ITSELF: Final = (255, 0)
"""Unit ids of a device on TCP that is no gateway (guide V1.0b, 4.4.2)."""
NO_TARGET: Final = frozenset({10, 11})
"""Exceptions of a gateway that reaches no device."""


def modbus_part(name: str, log: ModbusLog, source: str, prefix: str, place: int) -> RigPart:
    """Return the part for a bus; `place` numbers the buses, `prefix` begins the names of the devices."""
    remarks: list[str] = []
    rate = (log.rate or LineRate()).rate(is_ascii=log.is_ascii) if log.is_line else None
    line = _timing(rate.form, is_ascii=log.is_ascii) if rate is not None and log.rate is not None else None
    models = [
        UnitModel(f"{prefix}unit{asked_as}", unit_id, asked_as, unit, (log.start_ns, log.end_ns), line)
        for asked_as, unit_id, unit in _units(log, remarks)
    ]
    if log.broadcasts:
        remarks.append(f"{counted(log.broadcasts, 'broadcast')}, of which nothing is taken")
    part = RigPart(name, is_can=False, nodes=[model.unit_id for model in models])
    direct = next((model.unit_id for model in models if model.asked_as in DEVICE_ITSELF), None)
    part.buses = [*_bus(name, log, rate, remarks, place, direct if len(models) > 1 else None)]
    for model in models:
        path = PurePosixPath("registers", f"{model.name}.yaml")
        part.files[path] = model.table(source)
        if model.columns:
            part.files[model.recorded], cut_ns = csv_of(model.columns, log.end_ns - log.start_ns)
            if cut_ns is not None:
                model.remarks.append(f"values after {cut_ns / 1e9:.3f} s, because {model.recorded} would be too long")
        if model.times.single:
            part.files[model.answer_times] = model.times.file
        part.devices += _device(name, model, path)
        part.read_backs += model.read_backs(name)
    part.remarks = [f"{name}: {remark}" for remark in remarks]
    return part


def _units(log: ModbusLog, remarks: list[str]) -> Iterator[tuple[int, int, UnitLog]]:
    """Yield the units that answered: the id of the recording, and that in the rig."""
    is_direct = False
    remarks += _absent(log)
    for asked_as, unit in sorted(log.units.items()):
        if not _is_there(unit):
            continue
        if asked_as in UNIT_IDS:
            yield asked_as, asked_as, unit
        elif asked_as in DEVICE_ITSELF and not log.is_line and not is_direct:
            is_direct = True
            yield asked_as, next(free for free in UNIT_IDS if free not in log.units), unit
        else:
            remarks.append(f"unit {asked_as} has an id that no device of a rig can have: it is left out")


def _is_there(unit: UnitLog) -> bool:
    return unit.answers > 0 and not _is_beyond_a_gateway(unit)


def _absent(log: ModbusLog) -> Iterator[str]:
    """Yield the units that did not answer, in a sentence for those that were asked alike."""
    silent: dict[str, list[int]] = {}
    for unit_id, unit in sorted(log.units.items()):
        if not unit.answers and (unit_id or not log.is_line):  # nothing answers unit 0 of a line
            silent.setdefault(counted(unit.unanswered, "request"), []).append(unit_id)
    yield from (never_answered("unit", alike, asked) for asked, alike in silent.items())
    if beyond := [unit_id for unit_id, unit in log.units.items() if unit.answers and _is_beyond_a_gateway(unit)]:
        yield f"no gateway reached unit {ranges(beyond)} (exception 10 or 11): no devices here"


def _is_beyond_a_gateway(unit: UnitLog) -> bool:
    """True if all that came was that a gateway reached nothing."""
    codes = {code for group in unit.groups.values() for code in group.refused} | {*unit.refused_functions.values()}
    has_done = any(group.sample is not None for group in unit.groups.values())
    is_known = unit.identification or unit.server_id is not None or unit.status is not None or unit.functions
    return bool(codes) and codes <= NO_TARGET and not has_done and not is_known


def _bus(
    name: str, log: ModbusLog, rate: Rate | None, remarks: list[str], place: int, direct: int | None
) -> Iterator[str]:
    for remark in remarks:
        yield from comment(remark, 2)
    yield f"  {name}:"
    if rate is not None:
        yield f"    kind: modbus.{'ascii' if log.is_ascii else 'rtu'}"
        yield from _format(rate, is_ascii=log.is_ascii)
        yield f"    pty: {name}"
    else:
        yield "    kind: modbus.tcp"
        yield f"    listen: 127.0.0.1:{FIRST_PORT + place}"
        if any(not unit.answers for unit in log.units.values()):
            yield "    unknown_unit: silence"
        if direct is not None:
            yield f"    direct_unit: {direct}"


def _timing(form: Format, *, is_ascii: bool) -> LineTiming:
    return LineTiming("ascii" if is_ascii else "rtu", form.baud, form.bits_per_character)


def _format(rate: Rate, *, is_ascii: bool) -> Iterator[str]:
    form, words = rate
    yield f"    baud: {form.baud}  # {words}"
    if is_ascii:
        yield f"    data_bits: {form.data_bits}"
    yield f"    parity: {form.parity}"
    yield f"    stop_bits: {form.stop_bits}"


def _device(bus: str, model: UnitModel, table: PurePosixPath) -> Iterator[str]:
    yield ""
    for sentence in model.words_seen():
        yield from comment(sentence, 2)
    yield from unknown_lines(model.words_unknown())
    yield f"  {model.name}:"
    yield "    kind: modbus.device"
    yield f"    table: {flow(str(table))}"
    yield f"    unit_id: {model.unit_id}"
    yield f"    turnaround_ms: {model.turnaround_ms:g}"
    if model.times.single:
        yield f"    answer_times: {flow(str(model.answer_times))}"
    yield f"    links: {{modbus: {bus}}}"
    for key, value in model.more.items():
        yield f"    {key}: {flow(value)}"
    if model.faults:
        yield "    faults:"
        yield from (f"      - {flow(fault)}" for fault in model.faults)
