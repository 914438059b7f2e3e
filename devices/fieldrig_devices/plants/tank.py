"""A tank with a pump that fills it and an outlet that drains it.

An upright cylinder, open above.  The pump's flow is proportional to its speed; it turns while its run wire is
true, or by its speed alone until that wire is driven.  The outlet is in the bottom; the opening of its valve scales its
area.  Water above the rim runs over.  Between two changes of its inputs the level is the exact solution (`torricelli`),
so the step only sets how often the level is published; while nothing moves, no time is spent.  A fault changes the
vessel or what the instruments show; `level` and the flows remain the truth.
Left out: the pump's own inertia and back pressure, the valve's travel, waves.
"""

import math
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, NamedTuple, Self

from pydantic import Field, model_validator

from fieldrig.clock import MS, Clock, S
from fieldrig.device import Device, Point
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import number_in
from fieldrig.settings import Claim, Settings
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.tank_faults import MODELS, BlockedOutlet, Leak, StuckSensor, StuckSwitch
from fieldrig_devices.plants.torricelli import moved, root_coefficient


class TankSettings(Settings):
    area_m2: float = Field(gt=0, description="of the water's surface")
    height_m: float = Field(gt=0, description="of the rim above the outlet")
    outlet_area_m2: float = Field(ge=0, description="of the outlet with its valve at 100 %")
    discharge_coefficient: float = Field(default=0.62, gt=0, le=1, description="0.62 is a sharp-edged round hole")
    pump_flow_m3_per_s: float = Field(ge=0, description="at 100 % speed")
    initial_level_m: float = Field(default=0.0, ge=0)
    initial_outlet_percent: float = Field(default=0.0, ge=0, le=100, description="opening until its wire is driven")
    high_m: float | None = Field(
        default=None, description="level at which the high switch closes; default: 90 % of the height"
    )
    low_m: float | None = Field(
        default=None, description="level below which the low switch closes; default: 10 % of the height"
    )
    hysteresis_m: float = Field(default=0.01, ge=0, description="of both switches, towards the middle")
    step_ms: int = Field(default=10, ge=1, description="interval at which the level is published")
    level_resolution_m: float = Field(default=0.001, ge=0, description="smallest change that is published")
    flow_resolution_m3_per_s: float = Field(default=1e-6, ge=0, description="smallest change that is published")
    speed_wire: str = "pump.speed"
    run_wire: str = "pump.run"
    outlet_wire: str | None = Field(default=None, description="default: NAME.outlet, and so on for the others")
    level_wire: str | None = None
    inflow_wire: str | None = None
    outflow_wire: str | None = None
    high_wire: str | None = None
    low_wire: str | None = None

    @model_validator(mode="after")
    def _fits(self) -> Self:
        if self.initial_level_m > self.height_m:
            raise ValueError(f"initial_level_m is above the rim; expected 0 to {self.height_m} (height_m)")
        if not 0 <= self.low < self.high <= self.height_m:
            raise ValueError(f"low_m must be below high_m; expected both from 0 to {self.height_m} (height_m)")
        return self

    def claims(self, device: str) -> Iterator[Claim]:
        for what in ("level", "inflow", "outflow", "high", "low"):
            key = f"{what}_wire"
            yield Claim("wires", "wire", getattr(self, key) or f"{device}.{what}", (key,))

    @property
    def high(self) -> float:
        return 0.9 * self.height_m if self.high_m is None else self.high_m

    @property
    def low(self) -> float:
        return 0.1 * self.height_m if self.low_m is None else self.low_m


class _Water(NamedTuple):
    """The water in the tank at one instant, and the water that has left it."""

    level_m: float
    over_m3: float = 0.0
    overflows: int = 0
    dry_runs: int = 0


class Tank(Device):
    about = "a tank with a pump and an outlet (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: TankSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._water = _Water(settings.initial_level_m)
        self._speed = 0.0  # 0 to 1, like openings
        self._is_running = True
        self._opening = settings.initial_outlet_percent / 100
        self._outlet_k = self._leak_k = 0.0
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._open_holes()
        self._looked_ns = clock.now_ns()
        self._is_ticking = False
        self._is_high = self._is_low = False
        self._published: dict[str, float] = {}
        self._level_wire = settings.wire_for(name, "level")
        self._inflow_wire = settings.wire_for(name, "inflow")
        self._outflow_wire = settings.wire_for(name, "outflow")
        self._high_wire = settings.wire_for(name, "high")
        self._low_wire = settings.wire_for(name, "low")
        self._inputs = {
            settings.speed_wire: self._on_speed,
            settings.run_wire: self._on_run,
            settings.wire_for(name, "outlet"): self._on_outlet,
        }
        wires.on_receive(self._on_signal, tuple(self._inputs))

    def start(self) -> None:
        self._looked_ns = self._clock.now_ns()
        self._publish_all()
        self._keep_ticking()

    def front(self) -> Front:
        settings = self._settings
        return front.tank(settings.height_m, settings.high, settings.low)

    def points(self) -> Mapping[str, Point]:
        return {
            "level": Point(lambda: self._now().level_m, self._set_level, "m", "of the water above the outlet"),
            "volume": Point(lambda: self._now().level_m * self._settings.area_m2, None, "m3"),
            "inflow": Point(lambda: self._inflow, None, "m3/s", "from the pump"),
            "outflow": Point(lambda: self._outflow(self._now().level_m), None, "m3/s", "through the outlet"),
            "leak": Point(lambda: self._leak_k * math.sqrt(self._now().level_m), None, "m3/s", "through a leak"),
            "outlet": Point(lambda: 100 * self._opening, None, "%", "opening of the outlet's valve"),
            "high": Point(lambda: self._shows("high", self._now().level_m), None, "", "the switch for a high level"),
            "low": Point(lambda: self._shows("low", self._now().level_m), None, "", "the switch for a low level"),
            "overflow": Point(lambda: self._now().over_m3, None, "m3", "water that ran over the rim"),
            "overflows": Point(lambda: self._now().overflows, None, "", "number of overflows"),
            "dry_runs": Point(lambda: self._now().dry_runs, None, "", "number of times the tank ran empty"),
        }

    @property
    def _inflow(self) -> float:
        return self._settings.pump_flow_m3_per_s * self._speed if self._is_running else 0.0

    def _open_holes(self) -> None:
        """Let the valve's opening and the faults have their effect on the ways out from now on."""
        settings, coefficient = self._settings, self._settings.discharge_coefficient
        is_blocked = self._faults.first(BlockedOutlet) is not None
        opening = 0.0 if is_blocked else self._opening
        leaks_m2 = sum(fault.area_m2 for fault in self._faults.active(Leak))
        self._outlet_k = root_coefficient(coefficient * settings.outlet_area_m2 * opening)
        self._leak_k = root_coefficient(coefficient * leaks_m2)

    def _outflow(self, level_m: float) -> float:
        return self._outlet_k * math.sqrt(level_m)

    def _shows(self, switch: str, level_m: float) -> bool:
        """Return the state of a switch at a level, with its faults."""
        for fault in self._faults.active(StuckSwitch):
            if fault.switch == switch:
                stays = self._is_high if switch == "high" else self._is_low
                return stays if fault.shows is None else fault.shows
        return self._is_high_at(level_m) if switch == "high" else self._is_low_at(level_m)

    def _is_high_at(self, level_m: float) -> bool:
        return level_m >= self._settings.high - (self._settings.hysteresis_m if self._is_high else 0)

    def _is_low_at(self, level_m: float) -> bool:
        return level_m <= self._settings.low + (self._settings.hysteresis_m if self._is_low else 0)

    def _on_signal(self, signal: Signal) -> None:
        self._look()
        self._inputs[signal.name](signal.value)
        self._publish_flows()
        self._keep_ticking()

    def _on_speed(self, percent: float) -> None:
        self._speed = _share(percent)

    def _on_run(self, is_on: float) -> None:
        self._is_running = bool(is_on)

    def _on_outlet(self, percent: float) -> None:
        self._opening = _share(percent)
        self._open_holes()

    def _on_faults(self) -> None:
        self._look()
        self._open_holes()
        self._publish_all()
        self._keep_ticking()

    def _set_level(self, value: float | str) -> None:
        height_m = self._settings.height_m
        level_m = float(number_in(value, 0, height_m, "m"))
        self._look()
        self._water = self._water._replace(level_m=level_m)
        self._publish_all()
        self._keep_ticking()

    def _keep_ticking(self) -> None:
        """Keep the timer running only while something moves."""
        is_draining = self._outlet_k + self._leak_k > 0 and self._water.level_m > 0
        is_moving = self._inflow > 0 or is_draining
        if is_moving and not self._is_ticking:
            self._clock.call_at(self._clock.now_ns() + self._settings.step_ms * MS, self._on_tick)
        self._is_ticking = is_moving or self._is_ticking

    def _on_tick(self) -> None:
        self._is_ticking = False
        self._look()
        self._publish_all()
        self._keep_ticking()

    def _now(self) -> _Water:
        """Return the water at this instant, under the inputs since the last call of `_look`."""
        settings, water = self._settings, self._water
        seconds = (self._clock.now_ns() - self._looked_ns) / S
        if seconds <= 0:
            return water
        after = moved(
            water.level_m, self._inflow, self._outlet_k + self._leak_k, settings.area_m2, settings.height_m, seconds
        )
        runs_over = after.over_m3 > 0 and water.level_m < settings.height_m
        runs_dry = after.level_m == 0 and water.level_m > 0
        return _Water(
            after.level_m, water.over_m3 + after.over_m3, water.overflows + runs_over, water.dry_runs + runs_dry
        )

    def _look(self) -> None:
        """Advance the water to the present."""
        self._water, self._looked_ns = self._now(), max(self._clock.now_ns(), self._looked_ns)

    def _publish_all(self) -> None:
        settings, level_m = self._settings, self._water.level_m
        stuck = self._faults.first(StuckSensor)
        if stuck is None:
            self._publish(self._level_wire, level_m, "m", settings.level_resolution_m)
        elif stuck.level_m is not None:
            self._publish(self._level_wire, stuck.level_m, "m")
        self._publish_flows()
        self._is_high, self._is_low = self._shows("high", level_m), self._shows("low", level_m)
        self._publish(self._high_wire, self._is_high)
        self._publish(self._low_wire, self._is_low)

    def _publish_flows(self) -> None:
        resolution = self._settings.flow_resolution_m3_per_s
        self._publish(self._inflow_wire, self._inflow, "m3/s", resolution)
        self._publish(self._outflow_wire, self._outflow(self._water.level_m), "m3/s", resolution)

    def _publish(self, wire: str, value: bool | float, unit: str = "", resolution: float = 0.0) -> None:
        """Drive a wire whose value has changed by more than `resolution`, or has reached 0."""
        published = self._published.get(wire)
        if published is None or abs(value - published) > resolution or (value == 0 and published != 0):
            self._published[wire] = value
            self._wires.send(Signal(wire, value, unit))


def _share(percent: float) -> float:
    return min(max(percent, 0.0), 100.0) / 100
