"""A winder: a roll that supplies web to a line or takes it up, with drive, load cell, dancer and encoder.

The line sets the pace: a wire with its speed, or the encoder of the axis that drives it.  The drive of the roll turns
its reference into torque, as a current amplifier does; as a brake it only holds against the rotation.  Physics and
steps are in `winder_model`; a winder in which nothing moves takes no steps.  A web breaks by the point `break_web`, by
a fault, at `breaking_tension_n`, and where an unwound roll ends; `break_web=false` threads a new one.
Left out: the rollers between roll and line, lag and limits of the drive, the way of the web over the load cell.
"""

from collections.abc import Mapping
from copy import copy
from math import ceil, floor, isfinite
from typing import Any, ClassVar

from fieldrig.clock import US, Alarm, Clock, S
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.line_feed import LineFeed
from fieldrig_devices.plants.winder_model import WinderModel
from fieldrig_devices.plants.winder_settings import MODELS, Slip, Torn, WinderSettings

FULL_SCALE_V = 10.0
STILL_M_PER_S = 1e-6
STILL_M_PER_S2 = 1e-4
MOST_STEPS = 100  # after a longer pause the rest is skipped

LARGEST_FORCE_N = 1e6


class Winder(Device):
    """A winder as a device of a rig."""

    about = "a winder: roll, elastic web, drive, load cell and dancer (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: WinderSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._model = WinderModel(settings)
        self._line = LineFeed(settings.line_m_per_count)
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._is_torn = False
        """A fault tears the web."""
        self._grip = 1.0
        """The share of the line's way that draws web."""
        self._step_ns = settings.step_us * US
        self._volt = 0.0
        self._looked_ns = clock.now_ns()
        self._timer = Alarm(clock)
        self._is_moving = False
        self._motion: Motion | None = None
        self._published: dict[str, bool | float] = {}
        self._encoder_wire = settings.wire_for(name, "encoder")
        self._web_wire = settings.wire_for(name, "web")
        cell, dancer = settings.load_cell, settings.dancer
        self._cell_wire = (cell and cell.wire) or f"{name}.load_cell"
        self._dancer_wire = (dancer and dancer.wire) or f"{name}.dancer"
        self._reference_wire = settings.wire_for(name, "reference")
        self._look_at_model()
        wires.on_receive(self._on_signal, (self._reference_wire, settings.line_wire))

    def start(self) -> None:
        self._looked_ns = self._clock.now_ns()
        self._line.passed_m(self._looked_ns)
        self._go_on()

    def front(self) -> Front:
        settings = self._settings
        return front.winder(settings.core_radius_m, settings.initial_radius_m, settings.dancer is not None)

    def points(self) -> Mapping[str, Point]:
        settings, now, tension = self._settings, self._now, self._tension_now
        cell, dancer = settings.load_cell, settings.dancer
        points = {
            "tension": Point(tension, None, "N", "of the web"),
            "radius": Point(lambda: now().radius_m, self._write_radius, "m", "of the roll; write to mount another"),
            "length": Point(lambda: settings.length_m(now().radius_m), None, "m", "of the web on the roll"),
            "position": Point(lambda: now().angle, None, "rad", "of the roll; forward with the line"),
            "speed": Point(lambda: now().speed, None, "rad/s", "of the roll"),
            "inertia": Point(lambda: now().inertia, None, "kg m2", "of the roll"),
            "encoder": Point(lambda: floor(now().angle * settings.counts_per_rad), None, "count"),
            "line_speed": Point(lambda: self._line.speed(self._clock.now_ns()), None, "m/s"),
            "reference": Point(lambda: self._volt, None, "V", "to the drive"),
            "torque": Point(lambda: sum(self._drive()), None, "N m", "of the drive; positive pulls the web tight"),
            "slack": Point(lambda: max(0.0, -now().stretch_m), None, "m", "length of slack web"),
            "break_web": Point(
                lambda: now().is_broken, self._write_break, "", "true breaks the web, false threads a new one"
            ),
        }
        if cell is not None:
            points["load_cell"] = Point(lambda: cell.volt(tension()), None, "V")
        if dancer is not None:
            points["dancer"] = Point(lambda: now().dancer_m, None, "m", "position; 0 is the shortest loop")
            points["dancer_force"] = Point(lambda: now().dancer_force_n, self._write_force, "N", "draws the loop out")
        return points

    def _now(self) -> WinderModel:
        """Return roll and web at this instant; between two steps, as a copy that is ahead of the model."""
        now_ns = self._clock.now_ns()
        if now_ns <= self._looked_ns or not self._is_moving:
            return self._model
        ahead = copy(self._model)
        self._step(ahead, (now_ns - self._looked_ns) / S, copy(self._line).passed_m(now_ns) * self._grip)
        self._break_if_torn(ahead, ahead.tension(self._web_speed(now_ns)))
        return ahead

    def _tension_now(self) -> float:
        return self._now().tension(self._web_speed(self._clock.now_ns()))

    def _web_speed(self, now_ns: int) -> float:
        """Return the speed of the web at the line."""
        return self._line.speed(now_ns) * self._grip

    def _on_signal(self, signal: Signal) -> None:
        if not isfinite(signal.value):
            return
        self._look()
        if signal.name == self._reference_wire:
            self._volt = min(max(float(signal.value), -FULL_SCALE_V), FULL_SCALE_V)
        else:
            self._line.take(signal)
        self._go_on()

    def _write_break(self, value: Value) -> None:
        is_broken, model = truth_in(value), self._model
        if not is_broken and self._is_empty():
            raise ValueError("the roll is empty; set `radius` first")
        if not is_broken and self._is_torn:
            raise ValueError("a fault tears the web; clear it first")
        self._look()
        if is_broken:
            model.break_web()
        elif model.is_broken:
            model.thread_web()
        self._go_on()

    def _is_empty(self) -> bool:
        return self._settings.role == "unwinder" and self._model.radius_m <= self._settings.core_radius_m

    def _on_faults(self) -> None:
        """Let the faults have their effect from now on; a web is threaded where one was torn, if the roll has any."""
        self._look()
        was_torn, self._is_torn = self._is_torn, self._faults.first(Torn) is not None
        if self._is_torn:
            self._model.break_web()
        elif was_torn and not self._is_empty():
            self._model.thread_web()
        self._grip = 1.0
        for slip in self._faults.active(Slip):
            self._grip *= 1 - slip.percent / 100
        self._go_on()

    def _write_radius(self, value: Value) -> None:
        core_m = self._settings.core_radius_m
        radius_m = float(number_in(value, core_m, 100 * core_m, "m"))
        self._look()
        self._model.mount(radius_m)
        self._go_on()

    def _write_force(self, value: Value) -> None:
        force_n = float(number_in(value, 0, LARGEST_FORCE_N, "N"))
        self._look()
        self._model.dancer_force_n = force_n
        self._go_on()

    def _drive(self) -> tuple[float, float]:
        """Return the torque that pulls the web tight, and the one that holds the roll like dry friction."""
        torque = self._settings.torque_nm_at_10_v * self._volt / FULL_SCALE_V
        return (torque, 0.0) if self._settings.drive == "motor" else (0.0, max(0.0, torque))

    def _look(self) -> None:
        """Advance the model to the present, under the inputs since the last call."""
        now_ns = self._clock.now_ns()
        if now_ns <= self._looked_ns:
            return  # the web that passes at this instant is counted with the next step
        seconds, passed_m = (now_ns - self._looked_ns) / S, self._line.passed_m(now_ns) * self._grip
        self._looked_ns = now_ns
        if not self._is_moving:
            return
        self._step(self._model, seconds, passed_m)

    def _step(self, model: WinderModel, seconds: float, passed_m: float) -> None:
        torque, held = self._drive()
        steps = ceil(seconds * S / self._step_ns)  # more than one only after a pause of this process
        for _ in range(min(steps, MOST_STEPS)):
            model.step(seconds / steps, torque, held + self._settings.coulomb_nm, passed_m / steps)

    def _break_if_torn(self, model: WinderModel, tension: float) -> bool:
        """True if the web could not hold this tension."""
        breaking_n = self._settings.breaking_tension_n
        is_torn = breaking_n is not None and tension > breaking_n
        if is_torn:
            model.break_web()
        return is_torn

    def _look_at_model(self) -> None:
        """Publish the result of a step; True if anything still moves."""
        model = self._model
        self._tension = model.tension(self._web_speed(self._looked_ns))
        if self._break_if_torn(model, self._tension):
            self._tension = 0.0
        torque, held = self._drive()
        self._acceleration = model.acceleration(self._tension, torque, held + self._settings.coulomb_nm)
        radius_m = model.radius_m
        self._is_still = (
            self._line.is_still(self._looked_ns)
            and abs(model.speed) * radius_m < STILL_M_PER_S
            and abs(model.dancer_speed) < STILL_M_PER_S
            and abs(self._acceleration) * radius_m < STILL_M_PER_S2
            and abs(model.dancer_acceleration(self._tension)) < STILL_M_PER_S2
        )
        if self._is_still:
            model.speed = model.dancer_speed = self._acceleration = 0.0

    def _go_on(self) -> None:
        self._look_at_model()
        self._publish()
        self._is_moving = not self._is_still
        if not self._is_moving:
            self._timer.stop()
        elif self._looked_ns + self._step_ns < self._timer.when_ns:
            self._timer.at(self._looked_ns + self._step_ns, self._on_timer)

    def _on_timer(self) -> None:
        due_ns = self._looked_ns + self._step_ns
        if self._clock.now_ns() < due_ns:  # an input came first, and has taken a part of the step
            self._timer.at(due_ns, self._on_timer)
            return
        self._look()
        self._go_on()

    def _publish(self) -> None:
        model, cell, dancer = self._model, self._settings.load_cell, self._settings.dancer
        self._publish_encoder()
        if cell is not None:
            self._publish_signal(self._cell_wire, cell.volt(self._tension), "V", cell.resolution_v)
        if dancer is not None:
            self._publish_signal(self._dancer_wire, dancer.volt(model.dancer_m), "V", dancer.resolution_v)
        self._publish_signal(self._web_wire, not model.is_broken)

    def _publish_signal(self, wire: str, value: bool | float, unit: str = "", resolution: float = 0.0) -> None:
        published = self._published.get(wire)
        if published is None or abs(value - published) > resolution:
            self._published[wire] = value
            self._wires.send(Signal(wire, value, unit))

    def _publish_encoder(self) -> None:
        """Publish the encoder again before the extrapolated value would be off within the next step."""
        model, scale, published = self._model, self._settings.counts_per_rad, self._motion
        value, speed, acceleration = model.angle * scale, model.speed * scale, self._acceleration * scale
        now_ns, step_s = self._looked_ns, self._step_ns / S
        if published is not None:
            error = abs(published.at(now_ns) - value) + abs(published.speed_at(now_ns) - speed) * step_s
            error += abs(published.acceleration - acceleration) * step_s * step_s / 2
            is_resting = self._is_still and bool(published.speed or published.acceleration)
            if error < self._settings.encoder_tolerance_counts and not is_resting:
                return
        self._motion = Motion(self._encoder_wire, value, "count", now_ns, speed, acceleration)
        self._wires.send(self._motion)
