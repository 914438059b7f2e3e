"""A node of a recording as a device of a rig: its dictionary, its values, what it refuses, and what is not known."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig_devices.canopen.datatypes import Boolean, DataType, Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.heartbeat import PRODUCER_TIME
from fieldrig_devices.canopen.nmt import STARTUP
from fieldrig_devices.canopen.start_values import wrong_start
from fieldrig_devices.canopen.variable import FIRST_APPLICATION_INDEX, Variable
from fieldrig_devices.from_recording.can_log import CanLog, NodeLog
from fieldrig_devices.from_recording.columns import Column, column_of
from fieldrig_devices.from_recording.described_node import COMMANDS
from fieldrig_devices.from_recording.drive_pdos import usual_layout
from fieldrig_devices.from_recording.identifiers import Identifier
from fieldrig_devices.from_recording.known_objects import of_drives
from fieldrig_devices.from_recording.layout import DUMMIES, Layout, layout_of
from fieldrig_devices.from_recording.objects import Key
from fieldrig_devices.from_recording.pdos import Number, Pdo
from fieldrig_devices.from_recording.refusals import Refusals
from fieldrig_devices.from_recording.rhythm import FEWEST, ON_REQUEST, Rhythm, period_of, rhythm_of

DEVICE_TYPE: Final = 0x1000
IDENTITY: Final = frozenset({(DEVICE_TYPE, 0), (0x1018, 1), (0x1018, 2)})
"""Device type, vendor and product, which are the same in all devices that a file describes."""


@dataclass
class PdoModel:
    """A PDO of which the recording has frames."""

    pdo: Pdo
    identifier: int
    log: Identifier
    layout: Layout
    rhythm: Rhythm | None
    """None for a PDO that the node receives."""


@dataclass
class NodeModel:
    """One node, as it is written."""

    name: str
    node_id: int
    log: NodeLog
    is_drive: bool
    pdos: list[PdoModel]
    begin_ns: int
    """The instant from which its values count."""
    eds: Path = field(default_factory=Path)
    is_described: bool = False
    """True if a file of its maker describes it, and not the recording."""
    dictionary: Dictionary = field(default_factory=lambda: Dictionary(()))
    objects: dict[str, Any] = field(default_factory=dict)
    columns: dict[str, Column] = field(default_factory=dict)
    boot_up_ms: float = 0.0
    """Time that it takes to boot."""
    faults: list[dict[str, Any]] = field(default_factory=list)
    more: dict[str, Any] = field(default_factory=dict)
    """Further keys of the device in the rig file."""
    decisions: list[str] = field(default_factory=list)
    """Decisions with their reasons, in sentences without a period."""
    remarks: list[str] = field(default_factory=list)
    """Gaps in the knowledge, in sentences without a period."""


def pdo_models(
    bus: CanLog,
    pdos: Mapping[Pdo, int],
    number: Number,
    indices: frozenset[int],
    breaks: Sequence[int],
    *,
    is_drive: bool,
    is_refusing: bool,
) -> list[PdoModel]:
    """Return the PDOs of a node that were seen; `number` gives its parameters, `indices` the objects that it has.

    `breaks` are those of `rhythm_of`.  `is_refusing` is True for a node that reports PDOs of a wrong length.
    """
    found = []
    for pdo, identifier in sorted(pdos.items()):
        log = bus.identifiers[identifier]
        is_read = number(pdo.mapping, 0) is not None or number(pdo.mapping, 1) is not None
        assumed = usual_layout(pdo, log) if is_drive and not is_read else None
        is_refused = is_refusing and not pdo.is_transmitted
        layout = assumed or layout_of(pdo, number, log.length, indices, is_refused=is_refused)
        found.append(
            PdoModel(pdo, identifier, log, layout, rhythm_of(log, bus.sync_ns, breaks) if pdo.is_transmitted else None)
        )
    return found


def heartbeat_ms(log: NodeLog) -> int:
    """Return the value of 1017h at power-on.

    A node that its master configures in the recording has the value from before; without a heartbeat until then, it is
    0, which is the default of CiA 301.
    """
    seen = log.objects.by_key.get((PRODUCER_TIME, 0))
    period_ms = round(log.life.heartbeat_ns / MS)
    if seen is None or not seen.is_there:
        return period_ms
    if seen.first is not None:
        return int.from_bytes(seen.first, "little")
    assert seen.first_write_ns is not None, "it was written and not read"
    before = [instant for instant in log.life.heartbeats if instant < seen.first_write_ns]
    is_there = any(abs(later - earlier - log.life.heartbeat_ns) < 0.2 * log.life.heartbeat_ns
                   for earlier, later in pairwise(before))  # fmt: skip
    if is_there:
        return period_ms
    return round(period_of(before) / MS) if len(before) >= FEWEST else 0  # its master gives it another period


def runs_by_itself(log: NodeLog, pdos: list[PdoModel]) -> bool:
    """True if the node is operational although no NMT command of the recording has started it.

    The PDOs before its first boot-up are those of a node that was on, and started by a command before the recording.
    """
    sent = [model.log.first_ns for model in pdos if model.pdo.is_transmitted]
    if log.life.runs_by_itself or not sent:
        return log.life.runs_by_itself
    first_ns, boots, started_ns = min(sent), log.life.boots, log.life.started_ns
    was_on = bool(boots) and first_ns < boots[0].instant_ns
    return started_ns is None or (first_ns < started_ns and not was_on)


def fill(model: NodeModel) -> None:
    """Take the values, columns and refusals of a node whose dictionary is there."""
    _columns_of_pdos(model)
    _columns_of_objects(model)
    refusals = Refusals()
    refusals.take(model.log.objects.by_key, model.dictionary, partial(_is_driven, model))
    model.faults += refusals.faults
    model.remarks += refusals.remarks
    if refusals.left_out:
        model.remarks.append(f"{refusals.left_out} further refusals are left out")


def fill_described(model: NodeModel) -> None:
    """Give a node that a file describes the values of the recording."""
    missing = []
    for (index, subindex), log in model.log.objects.there().items():
        variable = model.dictionary.get(index, subindex)
        if variable is None:
            missing.append(f"{index:04X}:{subindex:02X}")
        elif log.start is not None and index not in COMMANDS and variable.key not in model.columns:
            if (index, subindex) in IDENTITY:
                _compare_identity(model, variable, log.start)
            _give(model, variable, log.start)
    if missing:
        model.remarks.append(f"the file lacks objects that the recording has: {', '.join(missing)}")
    heartbeat, period_ms = model.dictionary.get(PRODUCER_TIME), heartbeat_ms(model.log)
    if heartbeat is None and period_ms:
        model.remarks.append(f"the file has no 1017h: the heartbeat every {period_ms} ms is not sent")
    if heartbeat is not None and (PRODUCER_TIME, 0) not in model.log.objects.there() and period_ms:
        _give(model, heartbeat, period_ms.to_bytes(2, "little"))
    startup = model.dictionary.get(STARTUP)
    if startup is not None and startup.number and runs_by_itself(model.log, model.pdos):
        _give(model, startup, bytes(4))
    for pdo in model.pdos:
        _time(model, pdo)


def _compare_identity(model: NodeModel, variable: Variable, data: bytes) -> None:
    """Report a device type, vendor or product other than in the file; 0 and nothing in the file allow any."""
    found, described = int.from_bytes(data, "little"), int.from_bytes(variable.data, "little")
    if described and found != described:
        model.remarks.append(
            f"{variable.key} is {found:X}h in the recording, and {described:X}h in the file, "
            "which may be of another device"
        )


def _time(model: NodeModel, pdo: PdoModel) -> None:
    """Give a PDO of a described node the identifier and the times that the recording shows."""
    wanted = {1: pdo.identifier} if pdo.rhythm is None else {
        1: pdo.identifier, 2: pdo.rhythm.type, 3: pdo.rhythm.inhibit_100us, 5: pdo.rhythm.event_ms,
    }  # fmt: skip
    for subindex, number in wanted.items():
        variable = model.dictionary.get(pdo.pdo.parameter, subindex)
        if variable is None and subindex == 5 and number and pdo.log.count >= 4:
            name = f"{pdo.pdo.parameter:04X}:05"
            model.remarks.append(f"the file has no {name}: the PDO is not sent every {number} ms")
        is_said = (pdo.pdo.parameter, subindex) in model.log.objects.there()
        if variable is None or is_said or (subindex > 1 and pdo.log.count < 4):
            continue
        if subindex == 1 and variable.number & 0x7FF == number and variable.number < 1 << 31:
            continue
        _give(model, variable, number.to_bytes(variable.type.size or 4, "little"))


def _give(model: NodeModel, variable: Variable, data: bytes) -> None:
    """Give an object a value at power-on, if it differs from that of the file and the node can have it."""
    size = variable.type.size
    if size is not None and len(data) != size:
        if len(data) < size or any(data[size:]):
            model.remarks.append(f"{variable.key} has {len(data)} bytes in the recording, and {size} in the file")
            return
        data = data[:size]
    if data == variable.data:
        return
    before, variable.data = variable.data, data
    if variable.refusal(data) is not None or wrong_start(model.dictionary, variable):
        model.remarks.append(f"{variable.key} was {variable.value} in the recording, which the file does not allow")
        variable.data = before
        return
    value = variable.value
    variable.start = data
    model.objects[variable.key] = int(value) if isinstance(value, bool) else value


def _columns_of_pdos(model: NodeModel) -> None:
    for pdo in model.pdos:
        if pdo.rhythm is None:
            continue
        waits = pdo.rhythm.is_cyclic and model.dictionary.number(pdo.pdo.parameter, 3) == pdo.rhythm.inhibit_100us
        is_event = not pdo.rhythm.is_synchronous and not waits and pdo.rhythm.type != ON_REQUEST
        for place, part in enumerate(pdo.layout.parts):
            variable = model.dictionary.get(part.object, part.subindex)
            if variable is None or part.object in DUMMIES or _is_driven(model, part.key):
                continue
            show = _shown(variable.type, pdo.layout, place)
            if show is None or variable.key in model.columns:
                continue
            column = column_of(pdo.log.changes, model.begin_ns, show, is_event=is_event)
            if column.moves:
                model.columns[variable.key] = column


def _columns_of_objects(model: NodeModel) -> None:
    received = {part.key for pdo in model.pdos if pdo.rhythm is None for part in pdo.layout.parts}
    sent = {part.key for pdo in model.pdos if pdo.rhythm is not None for part in pdo.layout.parts}
    for key, log in model.log.objects.there().items():
        index, subindex = key
        variable = model.dictionary.get(index, subindex)
        is_own = index >= FIRST_APPLICATION_INDEX and key not in received | sent and not _is_driven(model, key)
        if variable is None or not log.is_moved or not is_own:
            continue
        if log.is_written:
            model.remarks.append(f"{variable.key} was written, and changed by itself too: it keeps what is written")
            continue
        show = _number_of(variable.type)
        if show is None:
            model.remarks.append(f"{variable.key} changed, and holds no number: it stays as it was first")
            continue
        column = column_of(log.values, model.begin_ns, show)
        if column.moves:
            model.columns[variable.key] = column


def _is_driven(model: NodeModel, key: Key) -> bool:
    """True if the emulated drive computes the object."""
    return model.is_drive and key[0] >= FIRST_APPLICATION_INDEX and of_drives().get(*key) is not None


def _shown(type: DataType, layout: Layout, place: int) -> Callable[[int], str] | None:
    show = _number_of(type)
    return None if show is None else lambda data: show(layout.values(data)[place])


def _number_of(type: DataType) -> Callable[[int], str] | None:
    """Return how a value, as an unsigned number of its bytes, is written; None for a type that holds no number."""
    if not isinstance(type, Integer | Real | Boolean):
        return None
    size = type.size or 1

    def show(number: int) -> str:
        value = type.decode((number & (1 << 8 * size) - 1).to_bytes(size, "little"))
        return str(int(value)) if isinstance(value, bool | int) else repr(value)

    return show
