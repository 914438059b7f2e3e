"""One unit of a Modbus device: the data model of its register table, and its values by name."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence

from fieldrig.device import Point
from fieldrig.errors import RigError
from fieldrig.points.checks import whole_in
from fieldrig.storage.store import StoreError
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_bus.wires import Signal
from fieldrig_devices.registers.image import Area, BitImage, RegisterImage
from fieldrig_devices.registers.table import (
    Bit,
    Fifo,
    Register,
    Table,
    Value,
    access_of,
    direction_of,
    words_of,
)
from fieldrig_devices.registers.value import BitValue, OutOfRange, RegisterValue
from fieldrig_devices.sources.living import Living

AnyValue = BitValue | RegisterValue


class FifoQueue:
    """A queue that function 24 reads."""

    def __init__(self, entry: Fifo) -> None:
        self.entry = entry
        self.values = deque(entry.initial, maxlen=entry.depth)
        self._heard: int | None = None

    def put(self, value: Value) -> None:
        """Append a value to the queue.  ValueError for a value that does not fit into a register."""
        self.values.append(whole_in(value, 0, 0xFFFF))

    def hear(self, signal: Signal) -> None:
        value = min(max(round(signal.value), 0), 0xFFFF)
        if value != self._heard:
            self._heard = value
            self.values.append(value)

    def point(self) -> Point:
        return Point(
            lambda: len(self.values),
            self.put,
            "",
            self.entry.about or "number of entries in the queue; writing appends an entry",
        )


class ModbusUnit:
    """Implements the `DataModel` protocol of fieldrig_bus.modbus.server.

    `drive` is called with each signal for a wire, `keep` before a change of `retained` takes effect; a StoreError of
    `keep` refuses the change.
    """

    def __init__(
        self,
        table: Table,
        out_of_range: OutOfRange,
        exception_status: int | Sequence[str],
        drive: Callable[[Signal], None],
        keep: Callable[[], None],
    ) -> None:
        self._table, self._drive, self._keep = table, drive, keep
        self.retained: dict[str, bytes] = {}
        """Raw retained values by name; they are stored before a write of them takes effect."""
        self._stored: Mapping[str, bytes] = {}
        """The retained values as they were last stored or restored."""
        self.coils = BitImage(_areas("coils", table.coils), self._commit)
        self.discrete_inputs = BitImage(_areas("discrete_inputs", table.discrete_inputs))
        self.holding_registers = RegisterImage(_areas("holding_registers", table.holding_registers), self._commit)
        self.input_registers = RegisterImage(_areas("input_registers", table.input_registers))
        self.values: dict[str, AnyValue] = {}
        for space, image in (("coils", self.coils), ("discrete_inputs", self.discrete_inputs)):
            for bit in table.coils if space == "coils" else table.discrete_inputs:
                for name, address in _each(bit):
                    self._add(BitValue(name, bit, address, direction_of(space, bit), image))
        self._add_registers("holding_registers", table.holding_registers, self.holding_registers, out_of_range)
        self._add_registers("input_registers", table.input_registers, self.input_registers, out_of_range)
        self._fifos = {entry.address: FifoQueue(entry) for entry in table.fifos}
        self._status = exception_status if isinstance(exception_status, int) else self._status_bits(exception_status)

    def fifo(self, address: int) -> list[int]:
        queue = self._fifos.get(address)
        if queue is None:
            raise ModbusError(ILLEGAL_DATA_ADDRESS)
        return list(queue.values)

    def exception_status(self) -> int:
        if isinstance(self._status, int):
            return self._status
        return sum(1 << position for position, value in enumerate(self._status) if value.read() is True)

    def listeners(self) -> list[tuple[str, Callable[[Signal], None]]]:
        """The wires that values read, with the handlers of their signals."""
        return [
            (value.entry.wire, value.hear)
            for value in self.values.values()
            if value.entry.wire is not None and value.direction == "from_wire"
        ]

    def living(self, prefix: str) -> list[Living]:
        """The values that live by themselves; their names after `prefix` are the seeds of what is random."""
        return [
            Living(value.entry.source.begin(prefix + value.name), value.live)
            for value in self.values.values()
            if value.entry.source is not None
        ]

    def collectors(self) -> list[tuple[str, Callable[[Signal], None]]]:
        """The wires whose changes are appended to queues, with the handlers of their signals."""
        return [(queue.entry.wire, queue.hear) for queue in self._fifos.values() if queue.entry.wire is not None]

    def drive_all(self) -> None:
        """Send the present values of all wires that this unit drives."""
        for value in self.values.values():
            if value.entry.wire is not None and value.direction == "to_wire":
                self._drive_wire(value)

    def usable(self, kept: Mapping[str, bytes]) -> dict[str, bytes]:
        """The stored values that still fit the table.  ValueError for a value that no client can have written."""
        found = {name: raw for name, raw in kept.items() if len(raw) == len(self.retained.get(name, b""))}
        for name, raw in found.items():
            self.values[name].check(raw)
        return found

    def restore(self, kept: Mapping[str, bytes]) -> None:
        """Restore values that `usable` returned."""
        for name, raw in kept.items():
            self.values[name].restore(raw)
        self.retained |= kept
        self._stored = kept

    def points(self) -> dict[str, Point]:
        points = {name: self._point(value) for name, value in self.values.items()}
        return points | {queue.entry.name: queue.point() for queue in self._fifos.values()}

    def _add_registers(
        self, space: str, entries: Sequence[Register], image: RegisterImage, out_of_range: OutOfRange
    ) -> None:
        for entry in entries:
            direction = direction_of(space, entry)
            for name, address in _each(entry):
                value = RegisterValue(name, entry, address, direction, image, self._table.form_of(entry), out_of_range)
                self._add(value, value.has_limits)

    def _add(self, value: AnyValue, is_watched: bool = False) -> None:
        self.values[value.name] = value
        if value.entry.retained:
            self.retained[value.name] = value.raw()
        drives = value.entry.wire is not None and value.direction == "to_wire"
        if is_watched or drives or value.entry.retained:
            value.watch(lambda: self._on_changed(value))

    def _commit(self, values: Sequence[AnyValue]) -> None:
        """Store the new values.  ModbusError if that fails."""
        try:
            self._retain(values)
        except StoreError as cause:
            raise ModbusError(SERVER_DEVICE_FAILURE) from cause

    def _retain(self, values: Sequence[AnyValue]) -> None:
        """Store `values`, which are complete; a half-written value of several registers is not stored."""
        changed = {value.name: value.raw() for value in values if value.entry.retained}
        if changed.items() <= self._stored.items():
            return
        before, self.retained = self.retained, self.retained | changed
        try:
            self._keep()
        except StoreError:
            self.retained = before
            raise
        self._stored = self.retained

    def _on_changed(self, value: AnyValue) -> None:
        if value.entry.wire is not None and value.direction == "to_wire":
            self._drive_wire(value)

    def _drive_wire(self, value: AnyValue) -> None:
        present = value.read()
        if value.entry.wire is not None and not isinstance(present, str):
            self._drive(Signal(value.entry.wire, present, value.unit))

    def _point(self, value: AnyValue) -> Point:
        def write(new: Value) -> None:
            before = value.raw()
            value.put(new)
            try:
                self._retain([value])
            except StoreError as cause:
                value.restore(before)
                reason = f"{value.name} cannot be stored: {cause.strerror}"
                raise ValueError(f"{reason}\nthe old value is kept") from cause
            self._on_changed(value)

        is_heard = value.entry.wire is not None and value.direction == "from_wire"
        is_fixed = is_heard or value.entry.source is not None
        return Point(value.read, None if is_fixed else write, value.unit, value.entry.about)

    def _status_bits(self, names: Sequence[str]) -> list[AnyValue]:
        unknown = [name for name in names if name not in self.values]
        if unknown:
            raise RigError(
                f"exception_status: unknown {', '.join(unknown)}", "expected names of the unit's register table"
            )
        return [self.values[name] for name in names]


def _areas(space: str, entries: Sequence[Bit | Register]) -> list[Area]:
    return [
        Area(entry.address, entry.count * words_of(entry), access != "wo", access != "ro")
        for entry in entries
        for access in (access_of(space, entry),)
    ]


def _each(entry: Bit | Register) -> list[tuple[str, int]]:
    """The name and address of each of the `count` values."""
    if entry.count == 1:
        return [(entry.name, entry.address)]
    return [(f"{entry.name}.{index}", entry.address + index * words_of(entry)) for index in range(entry.count)]
