"""A small DC motor: two contacts that turn it, a sensor with a pulse for each part of a turn, and a zero switch.

It is what a node moves that has two outputs and a counter for a motor (a Smart-IO).  With both contacts closed, or
neither, it coasts.  Left out: the load, and everything electrical.
"""

from collections.abc import Iterator, Mapping
from fractions import Fraction
from math import inf
from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.settings import Claim
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.dc_motor_model import DcMotorModel, MotorData
from fieldrig_devices.plants.settings import PlantSettings
from fieldrig_devices.pulses.output import Mode

MS_PER_S: Final = 1_000
FINEST: Final = 1_000
"""The largest denominator of the frequency of a pulse."""


class DcMotorSettings(PlantSettings):
    increase_wire: str = Field(description="input: digital, true turns the motor forwards")
    decrease_wire: str = Field(description="input: digital, true turns the motor backwards")
    pulses_per_s: float = Field(default=100.0, gt=0, le=10_000, description="speed of the motor")
    run_up_ms: float = Field(default=50.0, ge=0, description="time from rest to this speed")
    coast_ms: float = Field(default=40.0, ge=0, description="time from this speed to rest after switch-off")
    initial_position: float = Field(default=20.25, description="position at the start, in pulses")
    zero_from: float | None = Field(
        default=None, description="lower end of the zero switch, in pulses; null: it has none"
    )
    zero_to: float = Field(default=0.0, description="upper end of the zero switch, below which it is closed")
    low_stop: float | None = Field(default=None, description="lower mechanical stop, in pulses")
    high_stop: float | None = Field(default=None, description="upper mechanical stop, in pulses")
    pulse_wire: str | None = Field(default=None, description="output: digital, the pulses; default: NAME.pulse")
    zero_wire: str | None = Field(default=None, description="output: digital, the zero switch; default: NAME.zero")
    output: Mode = Field(
        default="edges",
        description="form of the pulses on the wire: a level with each edge, or segments of one pulse with its instant "
        "and the number of pulses before it",
    )

    @model_validator(mode="after")
    def _fits(self) -> Self:
        low, high = self.stops
        if not low < high or not low <= self.initial_position <= high:
            raise ValueError("initial_position: expected a position between low_stop and high_stop")
        if self.zero_from is not None and self.zero_from >= self.zero_to:
            raise ValueError(f"zero_from: expected less than zero_to, which is {self.zero_to:g}")
        return self

    @property
    def stops(self) -> tuple[float, float]:
        return (
            -inf if self.low_stop is None else self.low_stop,
            inf if self.high_stop is None else self.high_stop,
        )

    def outputs(self, device: str) -> dict[str, str]:
        """Return the wires that the motor drives, by their keys."""
        return {
            "pulse_wire": self.wire_for(device, "pulse"),
            "zero_wire": self.wire_for(device, "zero"),
        }

    def claims(self, device: str) -> Iterator[Claim]:
        for key, wire in self.outputs(device).items():
            yield Claim("wires", "wire", wire, (key,))


class Blocked(Timed):
    """The motor is blocked, and does not turn."""

    what: Literal["blocked"]


class NoPulses(Timed):
    """The sensor gives no pulses: its level stays."""

    what: Literal["no_pulses"]


class Welded(Timed):
    """The contact that is closed sticks, so the motor turns on."""

    what: Literal["welded"]


class Pushed(Timed):
    """Something turns the motor from outside while no contact is closed."""

    what: Literal["pushed"]
    pulses_per_s: float = Field(default=10.0, ge=-10_000, le=10_000, description="speed, negative backwards")


DcMotorFault = Annotated[Blocked | NoPulses | Welded | Pushed, Field(discriminator="what")]
MODELS: Final[Mapping[str, type[Any]]] = models_of(DcMotorFault)


class DcMotorPlant(Device):
    """A DC motor as a device of a rig."""

    about = "a small DC motor with two contacts, a pulse sensor and a zero switch (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: DcMotorSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        low, high = settings.stops
        data = MotorData(settings.pulses_per_s, settings.run_up_ms / MS_PER_S, settings.coast_ms / MS_PER_S, low, high)
        self._model = DcMotorModel(data, settings.initial_position)
        self._contacts = {settings.increase_wire: False, settings.decrease_wire: False}
        self._direction = 0
        """The direction that the contacts give."""
        self._outputs = settings.outputs(name)
        self._shown: dict[str, bool] = {}
        self._train: PulseTrain | None = None
        """The last pulse, if pulses are segments."""
        self._timer = Alarm(self._clock)
        wires.on_receive(self._on_signal, tuple(self._contacts))

    def start(self) -> None:
        if self._settings.output == "segments":
            now_ns = self._clock.now_ns()
            self._train = PulseTrain(self._outputs["pulse_wire"], 0, start_ns=now_ns, epoch_ns=now_ns)
            self._shown["pulse_wire"] = self._model.is_high
            self._wires.send(self._train)
        self._look()

    def front(self) -> Front:
        return front.dc_motor(self._settings.zero_from, self._settings.zero_to)

    def points(self) -> Mapping[str, Point]:
        model, now_ns = self._model, self._clock.now_ns
        return {
            "position": Point(lambda: model.position_at(now_ns()), None, "pulse", "of the shaft"),
            "speed": Point(lambda: model.speed_at(now_ns()), None, "1/s", "in pulses per second"),
            "direction": Point(lambda: self._direction, None, "", "that the contacts give: 1, -1 or 0"),
            "pulse": Point(lambda: self._shown.get("pulse_wire", False), None, "", "level of the sensor"),
            "zero": Point(self._is_zero, None, "", "the zero switch is closed"),
        }

    def _on_signal(self, signal: Signal) -> None:
        self._contacts[signal.name] = bool(signal.value)
        self._switch()

    def _switch(self) -> None:
        """Let contacts and faults have their effect from now on."""
        settings, now_ns = self._settings, self._clock.now_ns()
        wanted = self._contacts[settings.increase_wire] - self._contacts[settings.decrease_wire]
        if wanted or self._faults.first(Welded) is None:
            self._direction = wanted
        pushed = self._faults.first(Pushed)
        if self._faults.first(Blocked) is not None:
            self._model.turn(now_ns, 0.0)
        elif pushed is not None and not self._direction:
            self._model.turn(now_ns, pushed.pulses_per_s)
        else:
            self._model.drive(now_ns, self._direction)
        self._look()

    def _on_faults(self) -> None:
        self._switch()

    def _on_timer(self) -> None:
        self._model.advance(self._clock.now_ns())
        self._look()

    def _is_zero(self) -> bool:
        position, low = self._model.half / 2, self._settings.zero_from
        return position < self._settings.zero_to and (low is None or position >= low)

    def _look(self) -> None:
        """Show sensor and switch, and wait for the next event."""
        if self._faults.first(NoPulses) is None:
            self._show("pulse_wire", self._model.is_high)
        self._show("zero_wire", self._is_zero())
        self._timer.at(self._model.next_ns, self._on_timer)

    def _show(self, key: str, level: bool) -> None:
        if self._shown.get(key) is level:
            return
        self._shown[key] = level
        if key != "pulse_wire" or self._train is None:
            self._wires.send(Signal(self._outputs[key], level))
        elif level:
            self._send_pulse(self._train)

    def _send_pulse(self, before: PulseTrain) -> None:
        """Send a segment of one pulse, as long as one at the speed of the contacts; its totals are those before it."""
        now_ns = self._clock.now_ns()
        speed = self._model.speed_at(now_ns)
        frequency = Fraction(max(abs(speed), self._settings.pulses_per_s)).limit_denominator(FINEST)
        self._train = before.then(now_ns, frequency, count=1, direction=1 if speed > 0 else -1)
        self._wires.send(self._train)
