"""The items of a node that a PAM configures: what each reports, and which orders it takes."""

from collections.abc import Callable, Sequence
from typing import Final

from fieldrig.clock import MS, US, Clock
from fieldrig_devices.pamring.frames import (
    CounterItem,
    InputChanged,
    InputItem,
    KeyItem,
    Motor,
    MotorItem,
    MotorReport,
    OutputItem,
    Report,
)
from fieldrig_devices.smart_io.display import Display
from fieldrig_devices.smart_io.font import FIRST, LAST
from fieldrig_devices.smart_io.key import Key
from fieldrig_devices.smart_io.lamp import Lamp
from fieldrig_devices.smart_io.motor import OPERANDS, DcMotor, MotorLimits, wrapped
from fieldrig_devices.smart_io.scan import InputScan
from fieldrig_devices.smart_io.settings import SmartIoSettings
from fieldrig_devices.smart_io.terminals import Terminals
from fieldrig_devices.smart_io.troubles import MOTOR, NODE_BITS, FaultCode, Troubles

Send = Callable[[Report], None]
MOST_MV: Final = 10_000


class NodeItem:
    """One item.  An order that it does not know is not allowed: these methods then return False."""

    def run(self) -> None:
        """Begin to work, and report the first value."""

    def close(self) -> None:
        """End, with outputs inactive."""

    def lose_ring(self, holds: bool) -> None:
        """React to the silence of the ring; `holds` is true if outputs hold their values."""

    def set(self, value: int, number: int = 0) -> bool:
        return False

    def blink(self, on: bool) -> bool:
        return False

    def display(self, character: int) -> bool:
        return False

    def move(self, order: Motor, values: Sequence[int], number: int = 0) -> bool:
        return False

    def read(self) -> int | None:
        """Return the value that a `Read` asks for; None if it cannot be read."""
        return None


class Inputs(NodeItem):
    """A binary or digital input.  Its bits are electrical levels."""

    def __init__(
        self,
        clock: Clock,
        terminals: Terminals,
        item: InputItem,
        names: Sequence[str],
        send: Send,
        *,
        is_stamped: bool = False,
    ) -> None:
        """Reports of a single input say how long ago its level changed if `is_stamped` is true."""
        self._clock, self._item, self._send = clock, item.item, send
        self._is_stamped = is_stamped and item.bits == 1
        self._scan = InputScan(clock, terminals, names, item.period_ms * MS, item.debounce, self._on_change)
        self.is_single = item.bits == 1
        self.watcher: Callable[[], None] = _ignore
        """Called after each change, for a motor."""

    @property
    def value(self) -> int:
        return self._scan.value

    def run(self) -> None:
        self._scan.start()
        self._send(InputChanged(self._item, self._scan.value))

    def close(self) -> None:
        self._scan.stop()

    def _on_change(self) -> None:
        age_us = (self._clock.now_ns() - self._scan.edge_ns) // US if self._is_stamped else 0
        self._send(InputChanged(self._item, self._scan.value, age_us))
        self.watcher()


class PulseCounter(NodeItem):
    """Counts the edges to the active level of an input, for a DC motor."""

    def __init__(self, clock: Clock, terminals: Terminals, item: CounterItem, name: str, send: Send) -> None:
        self._item, self._send, self._active = item.item, send, int(item.is_active_high)
        self._scan = InputScan(clock, terminals, [name], item.period_ms * MS, item.debounce, self._on_change)
        self._count = 0
        self.step: Callable[[], int] = _up
        """Return 1 to count a pulse up, or -1 to count it down (G-09)."""
        self.watcher: Callable[[], None] = _ignore
        """Called with each pulse, for a motor."""

    def run(self) -> None:
        self._scan.start()
        self._send(InputChanged(self._item, self._count))

    def close(self) -> None:
        self._scan.stop()

    def _on_change(self) -> None:
        if self._scan.value == self._active:
            self._count = wrapped(self._count + self.step())
            self.watcher()
            self._send(InputChanged(self._item, self._count))


class KeyInput(NodeItem):
    """A key of the keyboard or of a binary input, with its mode."""

    def __init__(
        self, clock: Clock, terminals: Terminals, item: KeyItem, name: str, send: Send, *, is_pulsed: bool
    ) -> None:
        self._item, self._send, self._active = item.item, send, int(item.is_active_high)
        self._number = 0
        period_ns = item.period_ms * MS
        debounce = item.debounce if item.is_on_binary_input else 1
        self._scan = InputScan(clock, terminals, [name], period_ns, debounce, self._on_change)
        times = (period_ns, item.delay_ms * MS, item.repeat_ms * MS)
        self._key = Key(clock, item.mode, *times, self._report, is_pulsed=is_pulsed)

    def run(self) -> None:
        self._scan.start()
        self._key.start(self._scan.value == self._active)
        self._report()

    def close(self) -> None:
        self._scan.stop()
        self._key.stop()

    def set(self, value: int, number: int = 0) -> bool:
        """Take the state of a program, and answer: what was reported before is older than it."""
        self._number = number
        self._key.write(bool(value))
        self._report()
        return True

    def _on_change(self) -> None:
        self._key.put(self._scan.value == self._active)

    def _report(self) -> None:
        self._send(InputChanged(self._item, int(self._key.value), number=self._number))


class Outputs(NodeItem):
    """A binary or digital output.  Its bits are electrical levels; it begins inactive."""

    def __init__(self, terminals: Terminals, item: OutputItem, names: Sequence[str]) -> None:
        self._terminals, self._names = terminals, names
        self._inactive = 0 if item.is_active_high else (1 << item.bits) - 1
        self.is_single = item.bits == 1
        self.is_of_motor = False
        """True for an output that only its DC motor switches."""
        self._put(self._inactive)

    def close(self) -> None:
        self._put(self._inactive)

    def set(self, value: int, number: int = 0) -> bool:
        if self.is_of_motor:
            return False
        self._put(value)
        return True

    def lose_ring(self, holds: bool) -> None:
        if not holds and not self.is_of_motor:
            self._put(self._inactive)

    def activate(self, on: bool) -> None:
        self._put(self._inactive ^ int(on))

    def _put(self, bits: int) -> None:
        for bit, name in enumerate(self._names):
            self._terminals.drive(name, bool(bits >> bit & 1))


class Analog(NodeItem):
    """The analog output, in millivolts; it saturates at its ends (G-12)."""

    def __init__(self, put: Callable[[int], None]) -> None:
        self._put = put
        put(0)

    def close(self) -> None:
        self._put(0)

    def lose_ring(self, holds: bool) -> None:
        if not holds:
            self._put(0)

    def set(self, value: int, number: int = 0) -> bool:
        self._put(min(max(value, -MOST_MV), MOST_MV))
        return True


class Led(NodeItem):
    def __init__(self, lamp: Lamp) -> None:
        self._lamp = lamp
        lamp.clear()

    def close(self) -> None:
        self._lamp.clear()

    def set(self, value: int, number: int = 0) -> bool:
        self._lamp.set(bool(value))
        return True

    def blink(self, on: bool) -> bool:
        self._lamp.blink(on)
        return True


class SevenSegment(NodeItem):
    def __init__(self, display: Display) -> None:
        self._display = display
        display.clear()

    def close(self) -> None:
        self._display.clear()

    def blink(self, on: bool) -> bool:
        self._display.blink(on)
        return True

    def display(self, character: int) -> bool:
        if not FIRST <= character <= LAST:
            return False
        self._display.character = character
        return True


class MotorParts:
    """The items that a DC motor consists of."""

    def __init__(self, increase: Outputs, decrease: Outputs, zero: Inputs, counter: PulseCounter) -> None:
        self.increase, self.decrease, self.zero, self.counter = increase, decrease, zero, counter

    def join(self, on_pulse: Callable[[], None], on_zero: Callable[[], None]) -> None:
        """Give the parts to a motor."""
        self.increase.is_of_motor = self.decrease.is_of_motor = True
        self.counter.watcher, self.zero.watcher = on_pulse, on_zero

    def release(self) -> None:
        """Let the parts be items of their own again."""
        self.increase.is_of_motor = self.decrease.is_of_motor = False
        self.counter.watcher = self.zero.watcher = _ignore
        self.counter.step = _up

    def drive(self, direction: int) -> None:
        """Switch the outputs; the one that goes off is first."""
        for output, own in sorted(((self.increase, 1), (self.decrease, -1)), key=lambda one: one[1] == direction):
            output.activate(own == direction)


class MotorDrive(NodeItem):
    """A DC motor, whose errors are those of the node as well (12.1.1.7)."""

    def __init__(
        self,
        clock: Clock,
        item: MotorItem,
        parts: MotorParts,
        settings: SmartIoSettings,
        troubles: Troubles,
        send: Send,
    ) -> None:
        self._item, self._parts, self._troubles, self._send = item.item, parts, troubles, send
        self._told: frozenset[FaultCode] = frozenset()
        self._number = 0
        self._last: MotorReport | None = None
        readings = settings.readings
        own = MotorLimits(
            item.timeout_ms * MS, settings.motor_rest_ms * MS, readings.zero_at == "rest", readings.stray_pulses
        )
        self.motor = DcMotor(clock, own, item.braking, parts.drive, lambda: bool(parts.zero.value), self._report)
        parts.join(self.motor.on_pulse, self.motor.on_zero)
        if readings.counts == "direction":
            parts.counter.step = lambda: self.motor.direction

    def run(self) -> None:
        self._report()

    def close(self) -> None:
        self.motor.close()
        self._parts.release()

    def lose_ring(self, holds: bool) -> None:
        self.motor.halt()

    def move(self, order: Motor, values: Sequence[int], number: int = 0) -> bool:
        """Carry out an order, and report the state after it.

        Reports during the order still have the number of the one before, so none of them counts for this one.
        """
        is_taken = self.motor.order(order, values)
        self._number = number or self._number
        self._report()
        return is_taken

    def carry_out(self, order: Motor, values: Sequence[int]) -> bool:
        """Carry out an order with as many of the values as it takes."""
        return self.motor.order(order, values[: OPERANDS[order]])

    def read(self) -> int | None:
        return self.motor.position

    def _report(self) -> None:
        errors = self.motor.errors
        for fault in sorted(errors ^ self._told):
            details = (self._item, int(fault))
            self._troubles.set(fault in errors, MOTOR, details, NODE_BITS.get(fault, 0))
        self._told = errors
        report = MotorReport(self._item, self.motor.is_ready, self.motor.error_word, self._number)
        if report != self._last:
            self._last = report
            self._send(report)


def _up() -> int:
    return 1


def _ignore() -> None:
    """The item belongs to no motor."""
