"""A servo drive with a pulse input: position loop, motor and load, with following error, alarm and contacts.

The drive follows the pulses, made smooth within a period, by a proportional position loop up to the highest speed of
its motor.  So it lags behind them, and arrives at the last pulse exactly.  Between two events the motion is the exact
solution (`following_model`).  It is published as a `Motion`, again before the published parabola is off by
`tolerance_pulses`.  The drive gives an alarm when the following error is too large; then the motor stands, and the
pulses are lost, as they are while the drive is not enabled.
Single edges act as a command that steps.
Left out: torque and load; `plant.servo` has them, for a controller that closes the loops itself.
"""

from collections.abc import Collection, Iterator, Mapping
from math import ceil, tau
from typing import Annotated, Any, ClassVar, Final, Literal

from pydantic import Field

from fieldrig.clock import Alarm, Clock, S
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults, Timed, models_of
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import truth_in
from fieldrig.settings import Claim
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.following_model import Following
from fieldrig_devices.plants.settings import PlantSettings
from fieldrig_devices.pulses.pulse_input import PulseInput

_HORIZON_S: Final = 3600.0
_REST: Final = 1e-6  # pulses; an error below this is none
_NEARLY: Final = 1 - 1e-9


class PulseServoSettings(PlantSettings):
    pulse_wire: str = Field(description="input: pulses")
    direction_wire: str | None = Field(
        default=None, description="input: true is forwards; needed for single edges, as a pulse train has its direction"
    )
    pulses_per_turn: int = Field(
        default=10_000, ge=1, le=100_000_000, description="of the motor, by the electronic gear"
    )
    reversed: bool = Field(default=False, description="forward pulses turn the load backwards")
    gear_ratio: float = Field(default=1.0, gt=0, description="turns of the motor for one of the load")
    gain_per_s: float = Field(default=50.0, ge=0.1, le=10_000, description="gain of the position loop")
    highest_turns_per_s: float = Field(default=50.0, gt=0, description="of the motor")
    largest_error_pulses: float = Field(default=100_000.0, gt=0, description="following error that gives an alarm")
    window_pulses: float = Field(default=10.0, gt=0, description="following error below which it is in position")
    tolerance_pulses: float = Field(
        default=0.25, ge=1e-3, description="largest error of the extrapolated position before a new one is published"
    )
    enable_wire: str | None = Field(
        default=None, description="input: the drive works while it is true; default: always"
    )
    reset_wire: str | None = Field(
        default=None, description="input: a rising edge clears the alarm; default: NAME.reset"
    )
    position_wire: str | None = Field(default=None, description="output: of the load, rad; default: NAME.position")
    ready_wire: str | None = Field(default=None, description="output: the ready contact; default: NAME.ready")
    alarm_wire: str | None = Field(default=None, description="output: default: NAME.alarm")
    in_position_wire: str | None = Field(default=None, description="output: default: NAME.in_position")

    def outputs(self, device: str) -> dict[str, str]:
        """Return the wires that the drive drives, by their keys."""
        names = ("position", "ready", "alarm", "in_position")
        return {f"{name}_wire": getattr(self, f"{name}_wire") or f"{device}.{name}" for name in names}

    def claims(self, device: str) -> Iterator[Claim]:
        for key, wire in self.outputs(device).items():
            yield Claim("wires", "wire", wire, (key,))


class Jam(Timed):
    """The motor is blocked, so that the following error grows."""

    what: Literal["jam"]


class Trip(Timed):
    """The drive gives an alarm when the fault begins, for a reason of its own."""

    what: Literal["trip"]


MODELS: Final[Mapping[str, type[Any]]] = models_of(Annotated[Jam | Trip, Field(discriminator="what")])


class PulseServo(Device):
    """A servo drive with a pulse input as a device of a rig."""

    about = "a servo drive with a pulse input, motor and load (a plant, on wires)"
    trouble_keys: ClassVar[Collection[str]] = ("alarm", "lost")
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: PulseServoSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._pulses = PulseInput(clock.now_ns())
        self._scale = tau / settings.pulses_per_turn / settings.gear_ratio * (-1 if settings.reversed else 1)
        self._highest = settings.highest_turns_per_s * settings.pulses_per_turn
        self._since_ns = clock.now_ns()
        self._place = 0.0
        """Position of the motor in pulses while the drive does not work."""
        self._offset = 0.0
        """Pulses that were lost, with their signs: the wanted position is without them."""
        self._following: Following | None = None
        """The motion since `_since_ns`; None while the drive does not work."""
        self._is_enabled, self._is_alarm, self._is_reset = settings.enable_wire is None, False, False
        self._names = settings.outputs(name)
        self._published: dict[str, Signal] = {}
        self._timer = Alarm(self._clock)
        self._handlers = {settings.wire_for(name, "reset"): self._on_reset}
        for wire, handler in ((settings.enable_wire, self._on_enable), (settings.direction_wire, self._on_direction)):
            if wire is not None:
                self._handlers[wire] = handler
        wires.on_receive(self._on_signal, (settings.pulse_wire, *self._handlers))

    def start(self) -> None:
        self._pulses = PulseInput(self._clock.now_ns())
        self._on_change(self._place)

    def front(self) -> Front:
        return front.pulse_servo()

    def points(self) -> Mapping[str, Point]:
        now_ns, scale = self._clock.now_ns, self._scale
        return {
            "position": Point(lambda: self._now() * scale, None, "rad", "of the load"),
            "speed": Point(lambda: self._speed() * scale, None, "rad/s", "of the load"),
            "command": Point(self._command, None, "pulse", "wanted position"),
            "error": Point(self._error, None, "pulse", "following error"),
            "received": Point(lambda: self._pulses.received_at(now_ns()), None, "pulse", "in both directions"),
            "sent": Point(lambda: self._pulses.sent_at(now_ns()), None, "pulse", "by the sender"),
            "missed": Point(lambda: self._pulses.missed, None, "pulse", "sent, but never received"),
            "surplus": Point(lambda: self._pulses.surplus, None, "pulse", "received, but not sent"),
            "restarts": Point(lambda: self._pulses.restarts, None, "", "senders that started again"),
            "lost": Point(self._lost, None, "pulse", "received while the drive did not work, with their signs"),
            "in_position": Point(self._is_in_position, None, "", "the error is within the window, and no pulses come"),
            "enabled": Point(lambda: self._is_enabled, None, "", "by its input"),
            "alarm": Point(lambda: self._is_alarm, None, "", "of the drive"),
            "ready": Point(self._is_ready, None, "", "the ready contact"),
            "reset": Point(
                lambda: self._is_reset, self._write_reset, "", "the reset input; its rising edge clears the alarm"
            ),
        }  # fmt: skip

    # ---- inputs

    def _on_signal(self, signal: Signal) -> None:
        place = self._now()
        if signal.name != self._settings.pulse_wire:
            self._handlers[signal.name](bool(signal.value))
        elif isinstance(signal, PulseTrain) or type(signal) is Signal:
            if signal == self._pulses.present:
                return
            self._pulses.receive(signal, self._clock.now_ns())
        self._on_change(place)

    def _on_direction(self, level: bool) -> None:
        self._pulses.is_reverse = not level

    def _on_enable(self, level: bool) -> None:
        self._is_alarm = self._is_alarm and level
        self._is_enabled = level

    def _on_reset(self, level: bool) -> None:
        self._is_alarm = self._is_alarm and not (level and not self._is_reset)
        self._is_reset = level

    def _write_reset(self, value: Value) -> None:
        """Press the reset button of the drive, or release it."""
        place = self._now()
        self._on_reset(truth_in(value))
        self._on_change(place)

    def _on_faults(self) -> None:
        place = self._now()
        self._is_alarm = self._is_alarm or self._faults.first(Trip) is not None
        self._on_change(place)

    # ---- the motion, in pulses

    def _is_ready(self) -> bool:
        return self._is_enabled and not self._is_alarm

    def _train(self) -> PulseTrain | None:
        """The segment of the present instant, if it is one that moves."""
        train, now_ns = self._pulses.present, self._clock.now_ns()
        if not isinstance(train, PulseTrain) or train.count == 0 or train.start_ns > now_ns:
            return None
        end_ns = train.end_ns
        return train if end_ns is None or end_ns > now_ns else None

    def _command(self) -> float:
        """The wanted position, smooth within a period; that of the motor while the drive does not work."""
        if self._following is None:
            return self._place
        now_ns, train = self._clock.now_ns(), self._train()
        ahead = 0.0 if train is None else train.direction * float(1 - train.phase_at(now_ns))
        return self._pulses.position_at(now_ns) - ahead - self._offset

    def _seconds(self) -> float:
        return (self._clock.now_ns() - self._since_ns) / S

    def _error(self) -> float:
        return 0.0 if self._following is None else self._following.error_at(self._seconds())

    def _speed(self) -> float:
        return 0.0 if self._following is None else self._following.motion_at(self._seconds())[0]

    def _now(self) -> float:
        return self._command() - self._error()

    def _lost(self) -> float:
        if self._following is not None:
            return self._offset
        return self._pulses.position_at(self._clock.now_ns()) - self._place

    def _is_in_position(self) -> bool:
        return self._is_ready() and self._train() is None and abs(self._error()) <= self._settings.window_pulses

    def _on_change(self, place: float) -> None:
        """Begin a new motion from this position at the present instant, publish it, and wait for the next change."""
        self._since_ns = self._clock.now_ns()
        was_working, is_working = self._following is not None, self._is_ready()
        if is_working and not was_working:
            self._offset = self._pulses.position_at(self._since_ns) - place
            self._following = Following(0.0, 0.0, 0.0, 1.0, 1.0)
        if is_working:
            self._following = self._follow(self._command() - place)
            if abs(self._following.error) >= self._settings.largest_error_pulses * _NEARLY:
                self._is_alarm, is_working = True, False
        if not is_working:
            self._place, self._following = place, None
        self._publish()
        due_ns = self._next_ns()
        self._timer.at(due_ns, self._look)

    def _look(self) -> None:
        self._on_change(self._now())

    def _follow(self, error: float) -> Following:
        train, settings = self._train(), self._settings
        highest = 0.0 if self._faults.first(Jam) is not None else self._highest
        if train is None:
            return Following(error if abs(error) > _REST else 0.0, 0.0, 0.0, settings.gain_per_s, highest)
        speed, rate = train.speed_at(self._since_ns), train.direction * float(train.rate)
        return Following(error, speed, rate, settings.gain_per_s, highest)

    def _next_ns(self) -> int | None:
        """Return the next instant at which something changes or is published again; None if nothing will."""
        now_ns, train, following = self._since_ns, self._pulses.present, self._following
        ends = [train.start_ns, train.end_ns] if isinstance(train, PulseTrain) and train.count else []
        times = [when_ns for when_ns in ends if when_ns is not None and when_ns > now_ns]
        if following is not None and (following.error or following.speed or following.acceleration):
            within = min(following.seconds_within(self._settings.tolerance_pulses), _HORIZON_S)
            levels = (self._settings.largest_error_pulses, self._settings.window_pulses)
            within = min(
                following.seconds_to_change(within), *(following.seconds_to(at, within) for at in levels), within
            )
            times.append(now_ns + max(ceil(within * S), 1))
        return min(times, default=None)

    # ---- outputs

    def _publish(self) -> None:
        speed, rate = (0.0, 0.0) if self._following is None else self._following.motion_at(0.0)
        scale, names = self._scale, self._names
        self._send(
            Motion(names["position_wire"], self._now() * scale, "rad", self._since_ns, speed * scale, rate * scale)
        )
        self._send(Signal(names["ready_wire"], self._is_ready()))
        self._send(Signal(names["alarm_wire"], self._is_alarm))
        self._send(Signal(names["in_position_wire"], self._is_in_position()))

    def _send(self, signal: Signal) -> None:
        before = self._published.get(signal.name)
        is_same = before is not None and not signal.is_moving and not before.is_moving and signal.value == before.value
        if not is_same:
            self._published[signal.name] = signal
            self._wires.send(signal)
