"""One named value of a Modbus unit: its registers or its bit, read and written as a number in its unit."""

import math
import struct
from collections.abc import Callable
from typing import Literal

from fieldrig.point_values import number_in, text_in, truth_in
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_VALUE, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_bus.wires import Signal
from fieldrig_devices.registers.image import BitImage, RegisterImage
from fieldrig_devices.registers.table import FLOATS, FORMATS, Bit, Direction, Register, Value, WordOrder

OutOfRange = Literal["server_failure", "illegal_value", "limit"]


class BitValue:
    def __init__(self, name: str, entry: Bit, address: int, direction: Direction, image: BitImage) -> None:
        self.name, self.entry, self.direction = name, entry, direction
        self.unit = ""
        self._address, self._image = address, image
        self._on_written: Callable[[], None] | None = None
        image.put(address, entry.initial)

    def read(self) -> Value:
        return self._image.get(self._address)

    def put(self, value: Value) -> None:
        """Set the bit.  ValueError for a value that is not true or false."""
        self._image.put(self._address, truth_in(value, self.name))

    def hear(self, signal: Signal) -> None:
        """Take the level of a digital wire.  ValueError if the wire carries something else."""
        if not isinstance(signal.value, bool):
            raise ValueError(f"{self.name} is a bit: expected a digital wire, got {signal.value!r} on {signal.name}")
        self._image.put(self._address, signal.value)

    def raw(self) -> bytes:
        return bytes((self._image.get(self._address),))

    def check(self, raw: bytes) -> None:
        """ValueError for what `raw` didn't give."""
        if raw not in (b"\x00", b"\x01"):
            raise ValueError(f"{self.name} is no bit: {raw.hex()}")

    def restore(self, raw: bytes) -> None:
        """What `check` accepts."""
        self._image.put(self._address, raw == b"\x01")

    def watch(self, on_written: Callable[[], None]) -> None:
        self._on_written = on_written
        self._image.watch(self._address, self)

    def on_written(self) -> None:
        if self._on_written is not None:
            self._on_written()


class RegisterValue:
    def __init__(
        self,
        name: str,
        entry: Register,
        address: int,
        direction: Direction,
        image: RegisterImage,
        word_order: WordOrder,
        out_of_range: OutOfRange,
    ) -> None:
        self.name, self.entry, self.direction, self.unit = name, entry, direction, entry.unit
        self._address, self._words, self._image = address, entry.words, image
        self._is_swapped = (entry.word_order or word_order) == "little" and entry.type in FORMATS
        self._format = struct.Struct(f">{FORMATS[entry.type]}") if entry.type in FORMATS else None
        self._is_scaled = entry.scale != 1 or entry.offset != 0
        self._out_of_range = out_of_range
        self._on_written: Callable[[], None] | None = None
        if entry.initial is not None:
            self.put(entry.initial)

    def read(self) -> Value:
        return self._decode(self._image.get(self._address, self._words))

    def put(self, value: Value) -> None:
        """Set the value.  ValueError for one that is beyond the limits, or that the registers can't hold."""
        if self._format is not None and (self.has_limits or isinstance(value, bool | str)):
            number_in(value, self.entry.min, self.entry.max, self.unit, self.name)
        self._image.put(self._address, self._encode(value))

    def hear(self, signal: Signal) -> None:
        """A reading beyond what the register can say shows the register's end, as a real converter's does."""
        if signal.unit != self.unit:
            raise ValueError(f"{self.name} is in {self.unit!r}, the wire {signal.name} in {signal.unit!r}")
        if self._format is None:
            self.put(bool(signal.value))
        else:
            self._image.put(self._address, self._saturated(signal.value))

    def raw(self) -> bytes:
        return self._image.get(self._address, self._words)

    def check(self, raw: bytes) -> None:
        """ValueError for a value outside the limits; a wire may be outside."""
        value = self._decode(raw)
        if self._format is not None and self.direction != "from_wire" and not self._is_within(value):
            raise ValueError(f"{self.name} is {value}, expected {self._limits()}")

    def restore(self, raw: bytes) -> None:
        """What `check` accepts."""
        self._image.put(self._address, raw)

    def watch(self, on_written: Callable[[], None]) -> None:
        self._on_written = on_written
        self._image.watch(self._address, self._words, self)

    def _limits(self) -> str:
        low, high = self.entry.min, self.entry.max
        return " ".join(f"{'' if low is None else low} to {'' if high is None else high} {self.unit}".split())

    def _is_within(self, value: Value) -> bool:
        """True for a value that a client may write."""
        if isinstance(value, str):
            return True
        low, high = self.entry.min, self.entry.max
        if math.isfinite(value):
            return (low is None or value >= low) and (high is None or value <= high)
        return not self.has_limits and self.entry.wire is None

    @property
    def has_limits(self) -> bool:
        return self.entry.min is not None or self.entry.max is not None

    def limited(self, data: bytes) -> bytes:
        """Exception 04 by default: 03 "specifically does not mean that a data item has a value outside the
        expectation of the application program" (V1.1b3, chapter 7)."""
        value, low, high = self._decode(data), self.entry.min, self.entry.max
        if isinstance(value, str) or self._format is None or self._is_within(value):
            return data
        if self._out_of_range == "limit" and math.isfinite(value):
            return self._encode(low if low is not None and value < low else value if high is None else high)
        raise ModbusError(ILLEGAL_DATA_VALUE if self._out_of_range == "illegal_value" else SERVER_DEVICE_FAILURE)

    def on_written(self) -> None:
        if self._on_written is not None:
            self._on_written()

    def _decode(self, data: bytes) -> Value:
        if self._format is None:
            if self.entry.type == "bool":
                return any(data)
            return data.split(b"\x00")[0].decode("latin-1")
        value: int | float = self._format.unpack(_swapped(data) if self._is_swapped else data)[0]
        if not self._is_scaled:
            return value
        # Twelve digits: 3 * 0.1 is 0.3 to the person who wrote max: 0.3.
        return float(f"{value * self.entry.scale + self.entry.offset:.12g}")

    def _encode(self, value: Value) -> bytes:
        """Return the bytes of the registers.  ValueError for a value that they can't hold."""
        kind = self.entry.type
        if self._format is None:
            if kind == "bool":
                return b"\x00\x01" if truth_in(value, self.name) else b"\x00\x00"
            text = text_in(value, 2 * self._words, self.name)
            if not text.isascii():
                raise ValueError(f"{self.name}: expected a text in ASCII, got {text!r}")
            return text.encode().ljust(2 * self._words, b"\x00")
        assert not isinstance(value, str | bool), "`put` has refused it"
        raw = (value - self.entry.offset) / self.entry.scale if self._is_scaled else value
        try:
            data = self._format.pack(raw if kind in FLOATS else round(raw))
        except (struct.error, OverflowError, ValueError) as cause:
            raise ValueError(f"{self.name}: {value} doesn't fit into {kind} with scale {self.entry.scale}") from cause
        return _swapped(data) if self._is_swapped else data

    def _saturated(self, value: int | float) -> bytes:
        try:
            return self._encode(value + 0)  # a digital wire counts 0 or 1
        except ValueError:
            is_low = (value < 0) != (self.entry.scale < 0)
            data = _ends(self.entry.type)[0 if is_low else 1]
            return _swapped(data) if self._is_swapped else data


def _swapped(data: bytes) -> bytes:
    """The words in the opposite order, the bytes of each as they were."""
    return b"".join(data[at : at + 2] for at in range(len(data) - 2, -1, -2))


def _ends(kind: str) -> tuple[bytes, bytes]:
    """The lowest and the highest raw value of a type of number."""
    if kind in FLOATS:
        largest = b"\x7f\x7f\xff\xff" if kind == "f32" else b"\x7f\xef" + 6 * b"\xff"
        return bytes((0xFF, *largest[1:])), largest
    size = struct.calcsize(f">{FORMATS[kind]}")
    if kind.startswith("u"):
        return bytes(size), size * b"\xff"
    return b"\x80" + bytes(size - 1), b"\x7f" + (size - 1) * b"\xff"
