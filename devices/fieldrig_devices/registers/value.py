"""One named value of a Modbus unit: a bit, or registers that are read and written as a value in a unit."""

import math
import struct
from collections.abc import Callable
from typing import Final, Literal

from fieldrig.points.checks import number_in, text_in, truth_in, whole_in
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_VALUE, SERVER_DEVICE_FAILURE, ModbusError
from fieldrig_bus.wires import Signal
from fieldrig_devices.registers.entries import Bit, BitField, Direction, Register, Value, factor_in, number_of
from fieldrig_devices.registers.form import Form, characters_in
from fieldrig_devices.registers.image import BitImage, RegisterImage
from fieldrig_devices.sources.shapes import Number, is_on

Refusal = Literal["server_failure", "illegal_value"]
OutOfRange = Refusal | Literal["limit"]

REFUSALS: Final[dict[Refusal, int]] = {"server_failure": SERVER_DEVICE_FAILURE, "illegal_value": ILLEGAL_DATA_VALUE}
"""Exception codes for a value that is refused.

The default is 04: 03 "specifically does not mean that a data item has a value outside the expectation of the
application program" (V1.1b3, chapter 7).
"""


class BitValue:
    """One bit by its name."""

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

    def live(self, value: Number) -> None:
        """Take the value of a source, which is true from 0.5 on."""
        self._image.put(self._address, is_on(value))

    def raw(self) -> bytes:
        return bytes((self._image.get(self._address),))

    def check(self, raw: bytes) -> None:
        """ValueError for bytes that `raw` cannot have returned."""
        if raw not in (b"\x00", b"\x01"):
            raise ValueError(f"{self.name}: expected a bit, got {raw.hex()}")

    def restore(self, raw: bytes) -> None:
        """Restore a value that `check` accepts."""
        self._image.put(self._address, raw == b"\x01")

    def watch(self, on_written: Callable[[], None]) -> None:
        self._on_written = on_written
        self._image.watch(self._address, self)

    def on_written(self) -> None:
        if self._on_written is not None:
            self._on_written()


class RegisterValue:
    """One value in registers by its name."""

    def __init__(
        self,
        name: str,
        entry: Register,
        address: int,
        direction: Direction,
        image: RegisterImage,
        form: Form,
        out_of_range: OutOfRange,
    ) -> None:
        self.name, self.entry, self.direction, self.unit = name, entry, direction, entry.unit
        self._address, self._words, self._image = address, entry.words, image
        self._form = form
        self._is_scaled = entry.scale != 1 or entry.offset != 0 or entry.is_scaled_by_another
        self._factor: Callable[[], float] = lambda: 1
        self._lived: Number | None = None
        """The last value of the source."""
        self._out_of_range = out_of_range
        self._on_written: list[Callable[[], None]] = []

    def scale_by(self, other: "RegisterValue") -> None:
        """Let another register take part in the scale.

        The registers keep what they hold when it changes, but for a value that lives by itself, which `rescale` keeps.
        """
        is_exponent = self.entry.exponent_from is not None
        self._factor = lambda: factor_in(other.read(), is_exponent)

    def begin(self) -> None:
        """Take the value of the start.  ValueError for one that the registers cannot hold."""
        if self.entry.initial is not None:
            self.put(number_of(self.entry.values, self.entry.initial))

    def read(self) -> Value:
        return self._decode(self._image.get(self._address, self._words))

    def put(self, value: Value) -> None:
        """Set the value.  ValueError for one that is beyond the limits, or that the registers cannot hold."""
        if self._form.is_number and (self.has_limits or isinstance(value, bool | str)):
            number_in(value, self.entry.min, self.entry.max, self.unit, self.name)
        self._image.put(self._address, self._encode(value))

    def hear(self, signal: Signal) -> None:
        """Take the value of a wire.  A value beyond the range of the registers becomes the end of the range, as in a
        real converter."""
        if signal.unit != self.unit:
            raise ValueError(f"{self.name}: expected the unit {self.unit!r}, got {signal.unit!r} on {signal.name}")
        if self._form.is_number:
            self._image.put(self._address, self._saturated(signal.value))
        else:
            self.put(bool(signal.value))

    def live(self, value: Number) -> None:
        """Take the value of a source; one beyond the range of the registers becomes the end of the range."""
        self._lived = value
        if self._form.is_number:
            self._image.put(self._address, self._saturated(value))
        else:
            self.put(is_on(value))

    def rescale(self) -> None:
        """Encode the last value of the source again, because the register of its factor may have changed."""
        if self._lived is not None:
            self.live(self._lived)

    def raw(self) -> bytes:
        return self._image.get(self._address, self._words)

    def check(self, raw: bytes) -> None:
        """ValueError for a value outside the limits, unless it came from a wire."""
        value = self._decode(raw)
        if self._form.is_number and self.direction != "from_wire" and not self._is_within(value):
            raise ValueError(f"{self.name}: expected {self._limits()}, got {value}")

    def restore(self, raw: bytes) -> None:
        """Restore a value that `check` accepts."""
        self._image.put(self._address, raw)

    def watch(self, on_written: Callable[[], None]) -> None:
        self._on_written.append(on_written)
        self._image.watch(self._address, self._words, self)

    @property
    def bits(self) -> int:
        """The number in the registers, for the named bits of it."""
        return int(self._form.unpack(self.raw()))

    @bits.setter
    def bits(self, bits: int) -> None:
        self._image.put(self._address, self._form.pack(bits))

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
        """Return `data` within the limits, or raise ModbusError, as `out_of_range` says."""
        value, low, high = self._decode(data), self.entry.min, self.entry.max
        if isinstance(value, str) or not self._form.is_number or self._is_within(value):
            return data
        if self._out_of_range != "limit":
            raise ModbusError(REFUSALS[self._out_of_range])
        if not math.isfinite(value):
            raise ModbusError(SERVER_DEVICE_FAILURE)
        return self._encode(low if low is not None and value < low else value if high is None else high)

    def on_written(self) -> None:
        for act in self._on_written:
            act()

    def _decode(self, data: bytes) -> Value:
        if not self._form.is_number:
            return any(data) if self.entry.type == "bool" else self._form.unpack_text(data)
        value = self._form.unpack(data)
        if not self._is_scaled:
            return value
        # Twelve digits, so that 3 * 0.1 equals a limit of 0.3 in the table.
        return float(f"{value * self.entry.scale * self._factor() + self.entry.offset:.12g}")

    def _encode(self, value: Value) -> bytes:
        """Return the bytes of the registers.  ValueError for a value that they cannot hold."""
        kind = self.entry.type
        if not self._form.is_number:
            if kind == "bool":
                return self._form.pack_truth(truth_in(value, self.name))
            text = text_in(value, characters_in(kind), self.name)
            if not text.isascii():
                raise ValueError(f"{self.name}: expected a text in ASCII, got {text!r}")
            return self._form.pack_text(text.encode())
        assert not isinstance(value, str | bool), "`put` has refused it"
        raw = self._unscaled(value) if self._is_scaled else value
        try:
            return self._form.pack(raw if self._form.is_float else round(raw))
        except (struct.error, OverflowError, ValueError) as cause:
            fits = f"expected a value that fits into {kind} with scale {self.entry.scale}"
            raise ValueError(f"{self.name}: {fits}, got {value}") from cause

    def _saturated(self, value: int | float) -> bytes:
        try:
            return self._encode(value + 0)  # a digital wire counts as 0 or 1
        except ValueError:
            is_low = (value < 0) != (self.entry.scale * self._factor() < 0)
            return self._form.pack(self._form.low if is_low else self._form.high)

    def _unscaled(self, value: int | float) -> float:
        """The number in the registers; 0 if a register that takes part in the scale is 0."""
        scale = self.entry.scale * self._factor()
        return (value - self.entry.offset) / scale if scale else 0


class FieldValue:
    """Some named bits of a register."""

    unit = ""

    def __init__(self, owner: RegisterValue, entry: BitField, direction: Direction) -> None:
        self.name, self.owner, self.entry, self.direction = f"{owner.name}.{entry.name}", owner, entry, direction

    def read(self) -> Value:
        number = (self.owner.bits & self.entry.mask) >> self.entry.bit
        return bool(number) if self.entry.width == 1 else number

    def put(self, value: Value) -> None:
        """Set the bits.  ValueError for a value that they cannot hold."""
        highest = (1 << self.entry.width) - 1
        is_single = self.entry.width == 1
        self._set(int(truth_in(value, self.name)) if is_single else whole_in(value, 0, highest, name=self.name))

    def hear(self, signal: Signal) -> None:
        """Take the value of a wire; one beyond the range of the bits becomes the end of the range."""
        if self.entry.width == 1 and not isinstance(signal.value, bool):
            raise ValueError(f"{self.name} is a bit: expected a digital wire, got {signal.value!r} on {signal.name}")
        if math.isfinite(signal.value):
            self._set(min(max(round(signal.value), 0), (1 << self.entry.width) - 1))

    def _set(self, number: int) -> None:
        self.owner.bits = self.owner.bits & ~self.entry.mask | number << self.entry.bit
