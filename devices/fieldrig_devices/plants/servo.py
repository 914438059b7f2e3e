"""A servo axis: current amplifier, motor, gear, load, brake, encoder.

The amplifier turns its reference into torque, rated torque at 10 V, and does not control speed or position; that is
up to its controller.  Between two changes of its inputs the axis is the exact solution (`axis_model`).  The encoder is
published as a `Motion`: again when the motion changes, or before the published parabola is off by
`encoder_tolerance_counts`.  So an axis at standstill or at constant speed needs no work.  The value of the encoder is a
real number, of which a counter sees the integer part.  The brake opens on true, and holds until its wire is driven.
While the encoder's signal is lost its count stays; as the encoder is incremental, the counts that were missed are lost.
Left out: thermal limits, cogging, the voltage limit at high speed, elasticity, and the line noise of the encoder.
"""

from collections.abc import Mapping
from dataclasses import replace
from math import ceil, floor, inf, isfinite, tau
from typing import Any, ClassVar

from fieldrig.clock import Alarm, Clock, S
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.axis_model import Segment, State, after
from fieldrig_devices.plants.servo_settings import MODELS, Blocked, EncoderSignal, ServoSettings
from fieldrig_devices.plants.switches import Switch

FULL_SCALE_V = 10.0
LARGEST_LOAD_NM = 1e6  # limit for the value of a wire
HORIZON_S = 86_400.0
"""Longest time between two updates of a moving axis."""


class Servo(Device):
    """A servo axis as a device of a rig."""

    about = "a servo axis: current amplifier, motor, load and encoder (a plant, on wires)"
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: ServoSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._counts_per_rad = settings.counts_per_rad
        self._tolerance_rad = settings.encoder_tolerance_counts / abs(self._counts_per_rad)
        self._free = settings.mechanics()
        self._braked = settings.mechanics(settings.brake_torque_nm or 0.0)
        self._jammed = replace(self._free, breakaway=inf)
        self._volt = self._reference_nm = 0.0
        self._load_nm = 0.0  # external torque, at the load
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._held_count: float | None = None
        """The count at which the encoder's signal was lost; None while it is there."""
        self._lost_counts = 0.0
        self._is_blocked, self._is_braked = False, settings.brake_torque_nm is not None
        self._since_ns = clock.now_ns()
        self._state = State(settings.initial_position_rad * settings.gear_ratio)
        self._timer = Alarm(self._clock)
        self._encoder_wire = settings.wire_for(name, "encoder")
        self._published: Motion | None = None
        self._switches = _switches(settings)
        self._closed: dict[str, bool] = {}
        self._inputs = {
            settings.wire_for(name, "reference"): self._on_reference,
            settings.wire_for(name, "load_torque"): self._on_load_torque,
            settings.wire_for(name, "blocked"): self._on_blocked,
        }
        if settings.brake_torque_nm is not None:
            self._inputs[settings.wire_for(name, "brake")] = self._on_brake
        self._begin()
        wires.on_receive(self._on_signal, tuple(self._inputs))

    def start(self) -> None:
        self._since_ns = self._clock.now_ns()
        self._go_on()

    def front(self) -> Front:
        return front.servo()

    def points(self) -> Mapping[str, Point]:
        gear = self._settings.gear_ratio
        return {
            "position": Point(lambda: self._now().position / gear, None, "rad", "of the load"),
            "speed": Point(lambda: self._now().speed / gear, None, "rad/s", "of the load"),
            "encoder": Point(lambda: floor(self._count(self._now())), None, "count"),
            "reference": Point(lambda: self._volt, None, "V", "to the amplifier"),
            "torque": Point(lambda: self._now().torque, None, "N m", "of the motor"),
            "load_torque": Point(
                lambda: self._load_nm, self._write_load_torque, "N m", "external, at the load; positive pulls down"
            ),
            "blocked": Point(self._is_jammed, self._write_blocked, "", "the axis is jammed"),
            "brake": Point(lambda: self._is_braked, None, "", "the brake is applied"),
            "at_stop": Point(self._is_at_stop, None, "", "the load is at a stop"),
        }

    def _on_signal(self, signal: Signal) -> None:
        if isfinite(signal.value):
            self._inputs[signal.name](signal.value)

    def _on_reference(self, volt: float) -> None:
        volt = min(max(volt, -FULL_SCALE_V), FULL_SCALE_V)
        if volt != self._volt:
            self._look()
            self._volt, self._reference_nm = volt, self._settings.rated_torque_nm * volt / FULL_SCALE_V
            self._go_on()

    def _on_load_torque(self, torque_nm: float) -> None:
        torque_nm = min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM)
        if torque_nm != self._load_nm:
            self._look()
            self._load_nm = torque_nm
            self._go_on()

    def _on_blocked(self, is_on: float) -> None:
        self._look()
        self._is_blocked = bool(is_on)
        self._jam()

    def _on_brake(self, is_open: float) -> None:
        self._look()
        self._is_braked = not is_open
        self._go_on()

    def _is_jammed(self) -> bool:
        return self._is_blocked or self._faults.first(Blocked) is not None

    def _jam(self) -> None:
        """Go on, from a standstill if the axis is jammed."""
        if self._is_jammed():
            self._state = self._state._replace(speed=0.0)
        self._go_on()

    def _on_faults(self) -> None:
        self._look()
        is_lost, count = self._faults.first(EncoderSignal) is not None, self._count(self._state)
        if is_lost and self._held_count is None:
            self._held_count = count
        elif not is_lost and self._held_count is not None:
            self._held_count = None
            self._lost_counts += self._count(self._state) - count
        self._jam()

    def _count(self, state: State) -> float:
        """Return what the encoder shows in a state."""
        if self._held_count is not None:
            return self._held_count
        return state.position * self._counts_per_rad - self._lost_counts

    def _write_load_torque(self, value: Value) -> None:
        self._on_load_torque(number_in(value, unit="N m"))

    def _write_blocked(self, value: Value) -> None:
        self._on_blocked(truth_in(value))

    def _is_at_stop(self) -> bool:
        return self._now().position in (self._free.low, self._free.high)

    def _seconds(self) -> float:
        return (self._clock.now_ns() - self._since_ns) / S

    def _now(self) -> State:
        seconds = self._seconds()
        if seconds < self._ends_s:
            return self._segment.state(seconds)
        return after(self._mechanics, self._state, self._reference_nm, self._outer_nm, seconds)

    def _look(self) -> None:
        """Advance the state to the present, under the inputs since the last call."""
        self._state = self._now()
        self._since_ns = self._clock.now_ns()

    def _begin(self) -> None:
        """Start a new segment from the present state."""
        settings = self._settings
        self._mechanics = self._jammed if self._is_jammed() else self._braked if self._is_braked else self._free
        self._outer_nm = -(settings.load_torque_nm + self._load_nm) / settings.gear_ratio
        self._segment = Segment(self._mechanics, self._state, self._reference_nm, self._outer_nm)
        self._tangent = self._segment.tangent(self._tolerance_rad)
        within = min(self._tangent.seconds, HORIZON_S)
        end = self._segment.end(within)
        self._ends_s = inf if end is None else end.seconds
        self._wake_s = min(within, self._ends_s)

    def _go_on(self) -> None:
        self._begin()
        self._publish_encoder()
        if self._switches:
            self._publish_switches()
            self._wake_s = min(self._wake_s, self._seconds_to_switch())
        if self._segment.direction or self._ends_s < inf:
            self._timer.at(self._since_ns + max(1, ceil(self._wake_s * S)), self._on_timer)

    def _publish_encoder(self) -> None:
        is_lost, last = self._held_count is not None, self._published
        scale = 0.0 if is_lost else self._counts_per_rad
        speed, acceleration, _ = self._tangent
        value, is_still = self._count(self._state), is_lost or not self._segment.direction
        if last is not None and is_still and last.value == value and not last.speed:
            return  # its published position still holds
        self._published = Motion(
            self._encoder_wire, value, "count", self._since_ns, speed * scale, acceleration * scale
        )
        self._wires.send(self._published)

    def _publish_switches(self) -> None:
        for switch in self._switches:
            is_closed = switch.is_closed(self._state.position)
            if self._closed.get(switch.wire) is not is_closed:
                self._closed[switch.wire] = is_closed
                self._wires.send(Signal(switch.wire, is_closed))

    def _seconds_to_switch(self) -> float:
        """Return the time until the next switch changes, infinite if that is after the next update."""
        direction = self._segment.direction
        if not direction:
            return inf
        edges = [switch.next_change(self._state.position, direction) for switch in self._switches]
        edge = min(edges) if direction > 0 else max(edges)
        ahead = (edge - self._segment.at(self._wake_s)[0]) * direction
        return inf if ahead > 0 else self._segment.seconds_to(edge, self._wake_s)

    def _on_timer(self) -> None:
        self._look()
        self._go_on()


def _switches(settings: ServoSettings) -> list[Switch]:
    """Return the switches, in radians of the motor."""
    gear = settings.gear_ratio
    switches = [
        Switch(wire, cam.from_rad * gear, cam.to_rad * gear, inf if cam.every_rad is None else cam.every_rad * gear)
        for wire, cam in settings.switches.items()
    ]
    if settings.index_wire is not None:
        turn = tau * (gear if settings.encoder_at == "load" else 1.0)
        switches.append(Switch(settings.index_wire, 0.0, turn / (4 * settings.encoder_lines), turn))
    return switches
