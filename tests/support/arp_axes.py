"""The two axes of an ARP card on a bench: single control loops, programs, and a motor with its load."""

from collections.abc import Callable
from typing import Any, Final, Self

from arp_card import RecordedCard

from fieldrig.clock import MS
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.fixed import SCALE, WRONG_PARAMETER
from fieldrig_devices.arp.language.compiler import compile_text
from fieldrig_devices.arp.motion.axes import Axes
from fieldrig_devices.arp.motion.flags import FLAGS_BEFORE, AxisFlag
from fieldrig_devices.arp.parameters import Parameters
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.program import ArpProgram

PATIENCE_LOOPS: Final = 200_000

_OF_AXES: Final = (
    "position", "preset_position", "speed", "latched_rising", "latched_falling", "limit_speed", "limit_acceleration",
    "limit_deceleration", "home", "move_to", "move_by", "move_at", "follow_table", "stop_axis",
)  # fmt: skip


class Motor:
    """A current amplifier, a motor and its load: voltage causes torque, torque changes the speed, an encoder counts."""

    def __init__(self, gain: float, friction: float = 0.0) -> None:
        """`gain` is in counts/s2 per volt; `friction` is the share of the speed that is lost in a second."""
        self._gain, self._friction = gain, friction
        self.position = self.speed = 0.0  # counts, counts/s
        self.is_blocked = False

    def pass_time(self, seconds: float, volts: float) -> None:
        if self.is_blocked:
            self.speed = 0.0
            return
        self.speed += (self._gain * volts - self._friction * self.speed) * seconds
        self.position += self.speed * seconds

    @property
    def counts(self) -> int:
        return round(self.position)


class AxesBench:
    """Values are in units, as a program writes them; `F` and `V` are the card's lists."""

    def __init__(self, *parameters: tuple[int, int, float], readings: Readings | None = None, ms: int = 1) -> None:
        """Parameters are given by axis and number.  The axes are engaged and have done their first loop."""
        self.parameters = Parameters()
        self.card = RecordedCard()
        self.F, self.V = self.card.F, self.card.V
        self.errors = CardErrors(lambda code: None)
        for axis, number, value in parameters:
            self.set(axis, number, value)
        self.axes = Axes(self.parameters, self.F, self.V, self.errors, readings or Readings())
        self.counts: list[int | None] = [None, None, None]
        self.latches = [0, 0, 0]
        self.motors: dict[int, Motor] = {}
        self.program: ArpProgram | None = None
        self.period_ns = ms * MS
        self.now_ns = 0
        self.axes.start()
        self.axes.engage()
        self.loop()

    def set(self, axis: int, number: int, value: float) -> None:
        assert self.parameters.set_ram(axis, number, round(value * SCALE)), (axis, number, value)

    def write_table(self, first: int, *points: tuple[float, float]) -> None:
        """Set the variables of a PST."""
        values = [float(len(points)), *(value for point in points for value in point)]
        self.V[first : first + len(values)] = [round(value * SCALE) for value in values]

    def flag(self, axis: int, flag: AxisFlag) -> int:
        return self.F[FLAGS_BEFORE[axis] + flag]

    def raise_flag(self, axis: int, flag: AxisFlag) -> None:
        self.F[FLAGS_BEFORE[axis] + flag] = 1

    def position(self, axis: int) -> float:
        """Reference with all its digits."""
        return self.axes.diagnostic(axis, 4)

    def reading(self, axis: int) -> float:
        return self.axes.diagnostic(axis, 2)

    def speed(self, axis: int) -> float:
        """Speed of the reference."""
        return self.axes.diagnostic(axis, 5)

    def load(self, source: str) -> None:
        """Load a program; it runs from the next loop on, with 10 instructions in each."""
        for name in _OF_AXES:
            setattr(self.card, name, getattr(self.axes, name))
        replaced: dict[str, Callable[..., Any]] = {
            "axis_parameter": lambda axis, number: self.parameters.ram[axis][number],
            "set_axis_parameter": self._write_parameter,
            "last_error": lambda: self.errors.error,
            "warn": self.errors.warn,
        }
        for name, call in replaced.items():
            setattr(self.card, name, call)
        self.program = ArpProgram(compile_text(source), self.card)
        self.program.start()

    def _write_parameter(self, axis: int, number: int, raw: int) -> None:
        if not self.parameters.set_ram(axis, number, raw):
            self.errors.warn(WRONG_PARAMETER)

    def loop(self, times: int = 1) -> Self:
        for _ in range(times):
            self.now_ns += self.period_ns
            for axis, motor in self.motors.items():
                motor.pass_time(self.period_ns / 1e9, self.axes.volts(axis) or 0.0)
                self.counts[axis] = motor.counts
            self.axes.control(self.now_ns, self.counts, self.latches)
            if self.program is not None:
                self.card.time_ns = self.now_ns
                self.program.tick()
                self.program.run(10)
        return self

    def until(self, is_so: Callable[[], object]) -> int:
        """Loop until the condition is true.  Returns the number of loops."""
        for loops in range(PATIENCE_LOOPS):
            if is_so():
                return loops
            self.loop()
        raise AssertionError("it never came to that")

    def until_flag(self, axis: int, flag: AxisFlag, bit: int = 1) -> int:
        return self.until(lambda: self.flag(axis, flag) == bit)
