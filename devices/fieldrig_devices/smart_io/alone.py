"""The node without a PAM: its inputs are scanned, and clients work its outputs, LEDs, display and DC motors by points.

Once a PAM has taken the node over, points and faces only read: outputs belong to the ring until the node is switched
off or has lost its configuration.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig.device import Point, Value
from fieldrig.points.checks import truth_in, whole_in
from fieldrig_bus.wires import Signal
from fieldrig_devices.pamring.frames import CounterItem, InputItem, Motor, MotorItem, OutputItem, Report
from fieldrig_devices.smart_io.addresses import addresses_of, place_of
from fieldrig_devices.smart_io.board import Board
from fieldrig_devices.smart_io.font import FIRST, LAST
from fieldrig_devices.smart_io.items import MOST_MV, Inputs, MotorDrive, MotorParts, Outputs, PulseCounter
from fieldrig_devices.smart_io.lamp import Lamp
from fieldrig_devices.smart_io.scan import InputScan
from fieldrig_devices.smart_io.settings import MotorSettings, SmartIoSettings

OWNED: Final = "the PAM has the outputs\nexpected a node that no PAM has configured"
_LOWEST, _HIGHEST = -(1 << 31), (1 << 31) - 1


class Alone:
    """The stand-alone work of one node."""

    def __init__(self, clock: Clock, settings: SmartIoSettings, board: Board, on_change: Callable[[str], None]) -> None:
        """`on_change` is called with the name of each point that has changed."""
        self._clock, self._settings, self._board, self._on_change = clock, settings, board, on_change
        self.is_owned = False
        self._scans: dict[int, InputScan] = {}
        self._before: dict[int, int] = {}
        for module, own in sorted(settings.modules.items()):
            names = [f"in{address}" for address in addresses_of(module)]
            then = partial(self._on_scan, module)
            self._scans[module] = InputScan(clock, board.terminals, names, own.period_ms * MS, own.debounce, then)
        self._motors: list[LocalMotor] = []
        for number, motor in enumerate(settings.motors, 1):
            self._motors.append(LocalMotor(clock, settings, board, number, motor, on_change))
        for key in settings.keys:
            board.terminals.watch(f"key{key}", partial(on_change, f"key{key}"))

    def start(self) -> None:
        for module, scan in self._scans.items():
            scan.start()
            self._before[module] = scan.value
        for motor in self._motors:
            motor.start()

    def give_up(self) -> None:
        """Leave outputs and motors to a PAM, all of them off."""
        self.is_owned = True
        for motor in self._motors:
            motor.close()
        board = self._board
        for module in board.modules:
            for address in addresses_of(module):
                board.terminals.drive(f"out{address}", False)
        for lamp in board.lamps.values():
            lamp.clear()
        board.display.clear()
        board.put_analog(0)

    def take_back(self) -> None:
        """Work alone again, because the configuration of the PAM is lost."""
        self.is_owned = False
        for motor in self._motors:
            motor.start()

    def _on_scan(self, module: int) -> None:
        value = self._scans[module].value
        changed, self._before[module] = value ^ self._before[module], value
        for bit, address in enumerate(addresses_of(module)):
            if changed >> bit & 1:
                self._on_change(f"scan{address}")

    # ---- points

    def points(self) -> Iterator[tuple[str, Point]]:
        for module in sorted(self._scans):
            for bit, address in enumerate(addresses_of(module)):
                yield f"in{address}", self._input(f"in{address}", "level of the input")
                yield f"scan{address}", Point(partial(self._scanned, module, bit), about="accepted by the scan")
            for address in addresses_of(module):
                yield f"out{address}", self._output(f"out{address}")
        for key in self._settings.keys:
            yield f"key{key}", self._input(f"key{key}", "true while the key is pressed")
        for number, lamp in self._board.lamps.items():
            yield from self._lamp(f"led{number}", lamp)
        yield (
            "analog1",
            Point(
                lambda: self._board.millivolts,
                self._guarded(lambda value: self._board.put_analog(whole_in(value, -MOST_MV, MOST_MV, "mV"))),
                "mV",
                "analog output",
            ),
        )
        yield from self._display()
        for motor in self._motors:
            yield from motor.points(self._guarded)

    def _guarded(self, write: Callable[[Value], None]) -> Callable[[Value], None]:
        """Return a way to write that is refused while a PAM has the outputs."""

        def guarded(value: Value) -> None:
            if self.is_owned:
                raise ValueError(OWNED)
            write(value)

        return guarded

    def _input(self, terminal: str, about: str) -> Point:
        terminals = self._board.terminals

        def write(value: Value) -> None:
            terminals.put(terminal, Signal(terminal, truth_in(value)))

        return Point(partial(terminals.level, terminal), None if terminals.has_wire(terminal) else write, about=about)

    def _scanned(self, module: int, bit: int) -> bool:
        return bool(self._scans[module].value >> bit & 1)

    def _output(self, terminal: str) -> Point:
        terminals = self._board.terminals
        write = self._guarded(lambda value: terminals.drive(terminal, truth_in(value)))
        return Point(partial(terminals.is_on, terminal), write, about="level of the output")

    def _lamp(self, name: str, lamp: Lamp) -> Iterator[tuple[str, Point]]:
        set_lamp = self._guarded(lambda value: lamp.set(truth_in(value)))
        blink = self._guarded(lambda value: lamp.blink(truth_in(value)))
        yield name, Point(lambda: lamp.is_lit, set_lamp, about="LED, as it is at this instant")
        yield f"{name}.blink", Point(lambda: lamp.is_blinking, blink, about="blinking of the LED")

    def _display(self) -> Iterator[tuple[str, Point]]:
        display = self._board.display
        if not self._board.has_display:
            return

        def show(value: Value) -> None:
            display.character = whole_in(value, FIRST, LAST)

        blink = self._guarded(lambda value: display.blink(truth_in(value)))
        yield (
            "ring_leds",
            Point(lambda: display.has_ring_leds, about="red and yellow LED of the ring, with F-6 and F-7"),
        )
        yield "display", Point(lambda: display.text, about="a code of the node, or the character of the program")
        yield "display.segments", Point(lambda: display.segments, about="segments a to g and p that are lit now")
        yield "display.character", Point(lambda: display.character, self._guarded(show), about="code in the font HEXA")
        yield "display.blink", Point(lambda: display.is_blinking, blink, about="blinking of the display")


class LocalMotor:
    """A DC motor of the settings, worked by points: two values, then the order that takes them."""

    def __init__(
        self,
        clock: Clock,
        settings: SmartIoSettings,
        board: Board,
        number: int,
        own: MotorSettings,
        on_change: Callable[[str], None],
    ) -> None:
        self.name = f"motor{number}"
        self._clock, self._board, self._number, self._own = clock, board, number, own
        self._on_change, self._settings = on_change, settings
        self._modules = settings.modules
        self._values = [0, 0]
        self._last = 0
        self._drive: MotorDrive | None = None
        self._scans: Sequence[Inputs | PulseCounter] = ()

    def start(self) -> None:
        """Begin with the motor at position 0."""
        own, terminals = self._own, self._board.terminals
        zero_scan = self._modules[place_of(own.zero)[0]]
        pulse_scan = self._modules[place_of(own.counter)[0]]
        increase, decrease = (
            Outputs(terminals, OutputItem(0, address, 1, True), [f"out{address}"])
            for address in (own.increase, own.decrease)
        )
        zero = Inputs(
            self._clock,
            terminals,
            InputItem(0, own.zero, 1, True, zero_scan.period_ms, zero_scan.debounce),
            [f"in{own.zero}"],
            _ignore,
        )
        counter = PulseCounter(
            self._clock,
            terminals,
            CounterItem(0, own.counter, True, pulse_scan.period_ms, pulse_scan.debounce),
            f"in{own.counter}",
            self._on_pulse,
        )
        item = MotorItem(self._number, 0, 0, 0, 0, own.timeout_ms, own.braking)
        parts = MotorParts(increase, decrease, zero, counter)
        self._scans = (zero, counter)
        for scan in self._scans:
            scan.run()
        self._drive = MotorDrive(self._clock, item, parts, self._settings, self._board.troubles, self._on_report)

    def close(self) -> None:
        for scan in self._scans:
            scan.close()
        if self._drive is not None:
            self._drive.close()

    def _on_report(self, _report: Report) -> None:
        self._on_change(f"{self.name}.ready")
        self._on_change(f"{self.name}.error")
        self._on_change(f"{self.name}.position")

    def _on_pulse(self, _report: Report) -> None:
        self._on_change(f"{self.name}.position")

    def points(
        self, guarded: Callable[[Callable[[Value], None]], Callable[[Value], None]]
    ) -> Iterator[tuple[str, Point]]:
        name = self.name
        for index, key in enumerate(("value", "second")):
            write = guarded(partial(self._put, index))
            yield f"{name}.{key}", Point(partial(self._values.__getitem__, index), write, about="for the next order")
        yield (
            f"{name}.order",
            Point(lambda: self._last, guarded(self._order), about="order that is written: 1 to 8; 0 is none"),
        )
        yield f"{name}.position", Point(lambda: self._read("position"), unit="pulse")
        yield f"{name}.ready", Point(lambda: bool(self._read("is_ready")), about="false while an order is carried out")
        yield f"{name}.error", Point(lambda: self._read("error_word"), about="error word of the motor")

    def _read(self, what: str) -> int:
        return 0 if self._drive is None else int(getattr(self._drive.motor, what))

    def _put(self, index: int, value: Value) -> None:
        self._values[index] = whole_in(value, _LOWEST, _HIGHEST)

    def _order(self, value: Value) -> None:
        number = whole_in(value, 0, max(Motor))
        self._last = number
        if number and self._drive is not None and not self._drive.carry_out(Motor(number), self._values):
            raise ValueError(f"expected values that {Motor(number).name.lower()} takes, got {self._values}")


def _ignore(_report: Report) -> None:
    """The point of the input shows it."""
