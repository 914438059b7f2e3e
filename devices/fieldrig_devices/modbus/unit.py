"""One unit of a Modbus device: the data model of its register table, and its values by name."""

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from itertools import chain

from fieldrig.device import Point
from fieldrig.errors import RigError
from fieldrig.points.checks import choice_in, whole_in
from fieldrig.storage.store import StoreError
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_bus.wires import Signal
from fieldrig_devices.registers.entries import Bit, Fifo, RecordFile, Register, Value, each_value, number_of, words_of
from fieldrig_devices.registers.image import Area, BitImage, RegisterImage
from fieldrig_devices.registers.table import Table, access_of, direction_of
from fieldrig_devices.registers.value import BitValue, FieldValue, OutOfRange, RegisterValue
from fieldrig_devices.sources.living import Living

StoredValue = BitValue | RegisterValue
"""A value that may be retained."""
AnyValue = StoredValue | FieldValue


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
        self.values: dict[str, StoredValue] = {}
        self._places: dict[str, str] = {}
        """The type and the address of each value, such as `u16, holding register 4`."""
        self._fields: dict[str, list[FieldValue]] = {}
        """The named bits of registers that have some, by the names of the registers."""
        for space, image in (("coils", self.coils), ("discrete_inputs", self.discrete_inputs)):
            for bit in table.coils if space == "coils" else table.discrete_inputs:
                for name, address in each_value(bit):
                    self._add(BitValue(name, bit, address, direction_of(space, bit), image))
                    self._places[name] = f"{_one_of(space)} {address}"
        self._add_registers("holding_registers", table.holding_registers, self.holding_registers, out_of_range)
        self._add_registers("input_registers", table.input_registers, self.input_registers, out_of_range)
        self._begin()
        self._rescaled = [
            value
            for value in self.values.values()
            if isinstance(value, RegisterValue) and value.entry.source is not None and value.entry.is_scaled_by_another
        ]
        self._fifos = {entry.address: FifoQueue(entry) for entry in table.fifos}
        self.files = {file.number: _file(file) for file in table.files}
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
            for value in self._all()
            if value.entry.wire is not None and value.direction == "from_wire"
        ]

    def living(self, prefix: str) -> list[Living]:
        """The values that live by themselves; their names after `prefix` are the seeds of what is random."""
        return [
            Living(value.entry.source.begin(prefix + value.name), value.live)
            for value in self.values.values()
            if value.entry.source is not None
        ]

    @property
    def is_rescaled(self) -> bool:
        """True if values live by themselves whose scale is the value of another register."""
        return bool(self._rescaled)

    def rescale(self) -> None:
        """Encode the values again that live by themselves, if the register of their factor has changed."""
        for value in self._rescaled:
            value.rescale()

    def collectors(self) -> list[tuple[str, Callable[[Signal], None]]]:
        """The wires whose changes are appended to queues, with the handlers of their signals."""
        return [(queue.entry.wire, queue.hear) for queue in self._fifos.values() if queue.entry.wire is not None]

    def drive_all(self) -> None:
        """Send the present values of all wires that this unit drives."""
        for value in self._all():
            self._drive_wire(value)

    def usable(self, kept: Mapping[str, bytes]) -> dict[str, bytes]:
        """The stored values that still fit the table.  ValueError for a value that no client can have written."""
        fitting = {name: raw for name, raw in kept.items() if len(raw) == len(self.retained.get(name, b""))}
        for name, raw in fitting.items():
            self.values[name].check(raw)
        return fitting

    def restore(self, kept: Mapping[str, bytes]) -> None:
        """Restore values that `usable` returned."""
        for name, raw in kept.items():
            self.values[name].restore(raw)
        self.retained |= kept
        self._stored = kept

    def points(self) -> dict[str, Point]:
        points = {value.name: self._point(value) for value in self._all()}
        points |= {file.name: self._file_point(file) for file in self._table.files}
        return points | {queue.entry.name: queue.point() for queue in self._fifos.values()}

    def _add_registers(
        self, space: str, entries: Sequence[Register], image: RegisterImage, out_of_range: OutOfRange
    ) -> None:
        for entry in entries:
            direction = direction_of(space, entry)
            for name, address in each_value(entry):
                value = RegisterValue(name, entry, address, direction, image, self._table.form_of(entry), out_of_range)
                self._places[name] = f"{entry.type}, {_one_of(space)} {address}"
                fields = [FieldValue(value, field, direction_of(space, entry, field)) for field in entry.bits]
                if fields:
                    self._fields[name] = fields
                self._add(value, value.has_limits or any(map(_drives, fields)))

    def _add(self, value: StoredValue, is_watched: bool = False) -> None:
        self.values[value.name] = value
        if is_watched or _drives(value) or value.entry.retained:
            value.watch(lambda: self._on_changed(value))

    def _begin(self) -> None:
        """Give all registers their values of the start, first to those on which the scale of others depends."""
        registers = [value for value in self.values.values() if isinstance(value, RegisterValue)]
        for value in registers:
            other = self.values.get(value.entry.factor_from or value.entry.exponent_from or "")
            if isinstance(other, RegisterValue):
                value.scale_by(other)
        for value in sorted(registers, key=lambda value: value.entry.is_scaled_by_another):
            value.begin()
        self.retained = {value.name: value.raw() for value in self.values.values() if value.entry.retained}

    def _all(self) -> list[AnyValue]:
        return [*self.values.values(), *chain.from_iterable(self._fields.values())]

    def _commit(self, values: Sequence[StoredValue]) -> None:
        """Store the new values.  ModbusError if that fails."""
        try:
            self._retain(values)
        except StoreError as cause:
            raise ModbusError(SERVER_DEVICE_FAILURE) from cause

    def _retain(self, values: Sequence[StoredValue]) -> None:
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

    def _on_changed(self, value: StoredValue) -> None:
        self._drive_wire(value)
        for field in self._fields.get(value.name, ()):
            self._drive_wire(field)

    def _drive_wire(self, value: AnyValue) -> None:
        present = value.read()
        if _drives(value) and value.entry.wire is not None and not isinstance(present, str):
            self._drive(Signal(value.entry.wire, present, value.unit))

    def _point(self, value: AnyValue) -> Point:
        stored = value.owner if isinstance(value, FieldValue) else value
        names = {} if isinstance(value, BitValue) else value.entry.values

        def read() -> Value:
            present = value.read()
            return present if isinstance(present, str) else names.get(int(present), present) if names else present

        def write(new: Value) -> None:
            before = stored.raw()
            if names and isinstance(new, str):
                choice_in(new, names.values(), value.name)
            value.put(number_of(names, new))
            try:
                self._retain([stored])
            except StoreError as cause:
                stored.restore(before)
                reason = f"{value.name} cannot be stored: {cause.strerror}"
                raise ValueError(f"{reason}\nthe old value is kept") from cause
            self._on_changed(stored)

        is_heard = value.entry.wire is not None and value.direction == "from_wire"
        is_fixed = is_heard or (stored.entry.source is not None and stored.entry.access != "rw")
        about = value.entry.about or ", ".join(f"{number} {name}" for number, name in names.items())
        limited = value.entry if isinstance(value, RegisterValue) else None
        return Point(
            read,
            None if is_fixed else write,
            value.unit,
            about,
            type=self._place_of(value),
            low=None if limited is None else limited.min,
            high=None if limited is None else limited.max,
        )

    def _place_of(self, value: AnyValue) -> str:
        if not isinstance(value, FieldValue):
            return self._places[value.name]
        first, last = value.entry.bit, value.entry.bit + value.entry.width - 1
        return f"{self._places[value.owner.name]}, bit {first}" + (f" to {last}" if last > first else "")

    def _file_point(self, entry: RecordFile) -> Point:
        image = self.files[entry.number]

        def read() -> str:
            return image.get(0, entry.records).rstrip(b"\x00").hex()

        return Point(read, None, "", entry.about or "records up to the last one that is not 0, in hex")

    def _status_bits(self, names: Sequence[str]) -> list[AnyValue]:
        known = {value.name: value for value in self._all()}
        unknown = [name for name in names if name not in known]
        if unknown:
            raise RigError(
                f"exception_status: unknown {', '.join(unknown)}", "expected names of the unit's register table"
            )
        return [known[name] for name in names]


def _file(entry: RecordFile) -> RegisterImage:
    image = RegisterImage([Area(0, entry.records, True, entry.access == "rw")])
    image.put(0, b"".join(value.to_bytes(2, "big") for value in entry.initial))
    return image


def _one_of(space: str) -> str:
    """Return `holding register` for the space `holding_registers`."""
    return space.removesuffix("s").replace("_", " ")


def _drives(value: AnyValue) -> bool:
    """True for a value whose wire this unit drives."""
    return value.entry.wire is not None and value.direction == "to_wire"


def _areas(space: str, entries: Sequence[Bit | Register]) -> list[Area]:
    return [
        Area(entry.address, entry.count * words_of(entry), access != "wo", access != "ro")
        for entry in entries
        for access in (access_of(space, entry),)
    ]
