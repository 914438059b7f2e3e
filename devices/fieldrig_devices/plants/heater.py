"""A heater with its body: a heat capacity that power heats, and that loses heat to the surroundings.

The power is the duty of its input times the rated power: of a PWM output, of a number in %, or of a digital output.  A
PWM signal acts with its mean, as its period is short against the time constant.  Between two changes of its inputs the
temperature is the exact exponential.  It is published as a `Motion`, and again before the published line is off by
`tolerance_k`.  The switch `over` opens and closes at the instants of the exponential.
Left out: the ripple of the PWM, and different temperatures within the body.
"""

from collections.abc import Iterator, Mapping
from math import ceil, exp, inf, isfinite, log, sqrt
from typing import Annotated, Any, ClassVar, Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.clock import NEVER_NS, Alarm, Clock, S
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import number_in
from fieldrig.settings import Claim
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.settings import PlantSettings

ABSOLUTE_ZERO_DEGC: Final = -273.15
LARGEST_LOAD_W: Final = 1e9
HOTTEST_DEGC: Final = 1e6
LONGEST_WAIT_S: Final = 86_400.0
SHORTEST_WAIT_S: Final = 1e-9


class HeaterSettings(PlantSettings):
    power_w: float = Field(gt=0, description="at a duty of 100 %")
    heat_capacity_j_per_k: float = Field(gt=0)
    resistance_k_per_w: float = Field(gt=0, description="thermal resistance to the surroundings")
    ambient_degc: float = Field(default=20.0, ge=ABSOLUTE_ZERO_DEGC, description="temperature of the surroundings")
    initial_degc: float | None = Field(default=None, ge=ABSOLUTE_ZERO_DEGC, description="default: ambient_degc")
    limit_degc: float | None = Field(
        default=None, description="temperature above which the switch is on; default: none"
    )
    tolerance_k: float = Field(
        default=0.01, ge=1e-6, description="largest error of the extrapolated value before a new one is published"
    )
    power_wire: str | None = Field(default=None, description="input: PWM, % or digital; default: NAME.power")
    load_wire: str | None = Field(default=None, description="input: heat that is taken away, W; default: NAME.load")
    temperature_wire: str | None = Field(default=None, description="output: degC; default: NAME.temperature")
    over_wire: str | None = Field(default=None, description="output: the switch of limit_degc; default: NAME.over")

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if max(self.power_w * self.resistance_k_per_w + self.ambient_degc, self.initial_degc or 0) > HOTTEST_DEGC:
            raise ValueError(f"power_w and resistance_k_per_w: expected a temperature of at most {HOTTEST_DEGC:g} degC")
        return self

    @property
    def time_constant_s(self) -> float:
        return self.resistance_k_per_w * self.heat_capacity_j_per_k

    def claims(self, device: str) -> Iterator[Claim]:
        yield Claim("wires", "wire", self.wire_for(device, "temperature"), ("temperature_wire",))
        if self.limit_degc is not None:
            yield Claim("wires", "wire", self.wire_for(device, "over"), ("over_wire",))


class Broken(Timed):
    """The heating element is open: no power."""

    what: Literal["broken"]


class Stuck(Timed):
    """The output stage conducts all the time: full power."""

    what: Literal["stuck"]


MODELS: Final[Mapping[str, type[Any]]] = models_of(Annotated[Broken | Stuck, Field(discriminator="what")])


class Heater(Device):
    """A heater as a device of a rig."""

    about = "a heater that PWM drives, with the temperature of its body (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: HeaterSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._duty, self._load_w = 0.0, 0.0
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_change
        )
        self._since_ns = clock.now_ns()
        self._begin_degc = settings.ambient_degc if settings.initial_degc is None else settings.initial_degc
        self._final_degc = settings.ambient_degc
        self._temperature_wire = settings.wire_for(name, "temperature")
        self._over_wire = settings.wire_for(name, "over")
        self._power_wire = settings.wire_for(name, "power")
        self._is_over: bool | None = None
        self._published: Motion | None = None
        self._timer = Alarm(self._clock)
        wires.on_receive(self._on_signal, (self._power_wire, settings.wire_for(name, "load")))

    def start(self) -> None:
        self._since_ns = self._clock.now_ns()
        self._on_change()

    def front(self) -> Front:
        return front.heater(self._settings.limit_degc)

    def points(self) -> Mapping[str, Point]:
        return {
            "temperature": Point(self._now_degc, None, "degC"),
            "power": Point(self._power_w, None, "W"),
            "duty": Point(lambda: self._duty, None, "%", "of the input"),
            "load": Point(lambda: self._load_w, self._write_load, "W", "heat that is taken away"),
            "over": Point(self._is_hot, None, "", "above limit_degc"),
        }

    def _on_signal(self, signal: Signal) -> None:
        if not isfinite(signal.value):
            return
        if signal.name == self._power_wire:
            duty = signal.value * 100.0 if isinstance(signal.value, bool) else signal.value
            self._duty = min(max(float(duty), 0.0), 100.0)
        else:
            self._load_w = min(max(float(signal.value), -LARGEST_LOAD_W), LARGEST_LOAD_W)
        self._on_change()

    def _write_load(self, value: Value) -> None:
        self._load_w = float(number_in(value, -LARGEST_LOAD_W, LARGEST_LOAD_W, "W"))
        self._on_change()

    def _power_w(self) -> float:
        if self._faults.first(Broken) is not None:
            return 0.0
        duty = 100.0 if self._faults.first(Stuck) is not None else self._duty
        return self._settings.power_w * duty / 100

    def _now_degc(self) -> float:
        seconds = (self._clock.now_ns() - self._since_ns) / S
        return self._final_degc + (self._begin_degc - self._final_degc) * exp(-seconds / self._settings.time_constant_s)

    def _is_hot(self) -> bool:
        limit_degc = self._settings.limit_degc
        return limit_degc is not None and self._now_degc() >= limit_degc

    def _on_change(self) -> None:
        """Begin a new exponential at the present instant."""
        settings, self._begin_degc = self._settings, self._now_degc()
        self._since_ns = self._clock.now_ns()
        rise_k = (self._power_w() - self._load_w) * settings.resistance_k_per_w
        self._final_degc = max(settings.ambient_degc + rise_k, ABSOLUTE_ZERO_DEGC)
        self._publish()
        self._timer.stop()
        wait_ns = self._wait_ns()
        self._timer.at(self._since_ns + wait_ns, self._on_change)

    def _publish(self) -> None:
        ahead_k, constant_s = self._final_degc - self._begin_degc, self._settings.time_constant_s
        speed = ahead_k / constant_s if abs(ahead_k) > self._settings.tolerance_k else 0.0
        before = self._published
        if before is None or speed or before.speed or before.value != self._begin_degc:
            self._published = Motion(self._temperature_wire, self._begin_degc, "degC", self._since_ns, speed)
            self._wires.send(self._published)
        if self._settings.limit_degc is not None and self._is_hot() is not self._is_over:
            self._is_over = self._is_hot()
            self._wires.send(Signal(self._over_wire, self._is_over))

    def _wait_ns(self) -> int:
        """Return how long the published line is good enough, and the switch stays as it is."""
        ahead_k, constant_s = self._final_degc - self._begin_degc, self._settings.time_constant_s
        seconds = inf
        if abs(ahead_k) > self._settings.tolerance_k:
            seconds = min(constant_s * sqrt(2 * self._settings.tolerance_k / abs(ahead_k)), LONGEST_WAIT_S)
        limit_degc = self._settings.limit_degc
        if limit_degc is not None and ahead_k and 0 <= (limit_degc - self._begin_degc) / ahead_k < 1:
            seconds = min(seconds, max(constant_s * log(ahead_k / (self._final_degc - limit_degc)), SHORTEST_WAIT_S))
        return max(ceil(seconds * S), 1) if seconds * S < NEVER_NS else NEVER_NS
