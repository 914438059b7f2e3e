"""Drive, motor and load of a stepper as a function of the instants of its pulses and inputs.

It reads no clock: `stepper` says what happens when, and takes it again in order if a message was late (`replay`).
"""

from collections.abc import Iterator
from copy import copy
from typing import Final, Self

from fieldrig.clock import MS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Signal
from fieldrig_devices.plants.stepper_model import Followed, Motor, PullOut, falls_to_ns, jump_hz, passes_ns
from fieldrig_devices.plants.stepper_settings import StepperSettings
from fieldrig_devices.pulses.edge_rate import EdgeRate
from fieldrig_devices.pulses.pulse_input import PulseInput

SILENCE_NS: Final = 250 * MS
"""Time after which a sender that sends no next segment counts as at rest.  One that says that it rests is believed at
once; one that is silent may be a process that the host has held up."""
POLE_PAIRS: Final = 50
"""The pole pairs of the usual hybrid stepper with 200 full steps, which locks in again at every fourth of them."""


class StepperState:
    """The state at `now_ns`, with the pulses that each wire says from then on."""

    def __init__(self, settings: StepperSettings, now_ns: int) -> None:
        self.now_ns = now_ns
        self.due_ns: int | None = None
        """The next instant at which something changes by itself; None if nothing will."""
        self._settings = settings
        self._motor = Motor(
            PullOut(settings.pull_out), settings.pulses_per_turn, settings.inertia_kg_m2, settings.coulomb_nm,
            settings.highest_hz,
        )  # fmt: skip
        self.signs = {settings.pulse_wire: 1} | ({} if settings.ccw_wire is None else {settings.ccw_wire: -1})
        self.pulses = {wire: PulseInput(now_ns) for wire in self.signs}
        self._rates = {wire: EdgeRate() for wire in self.signs}
        self.load_nm = 0.0  # external, at the load
        self._torque_left, self._is_jammed = 1.0, False
        self.is_enabled = settings.enable_wire is None
        self.is_in_step, self.is_alarm, self.is_reset = True, False, False
        self._steps = self._lost = 0
        """Position of the motor, and pulses in both directions that it did not follow, up to the marks."""
        self._mark = self._received_mark = 0
        """Position and number of received pulses from which on `_steps` and `_lost` go on."""
        self._marked_ns = now_ns - 1
        self.is_following = False
        self._followed: dict[str, Followed] = {}
        """The last segments that the motor turned with."""
        self.turning: list[tuple[int, PulseTrain]] = []
        """The segments that are not over, each with the sign of its input."""

    def copy(self) -> Self:
        # Flat, as whatever is behind an attribute is replaced and never changed: `replay` copies the state at each
        # event.  Parts with states of their own would have to be copied one by one.
        return copy(self)

    # ---- what happens

    def switch_on(self) -> None:
        """Count pulses from the present instant on."""
        self._mark_down(self.now_ns - 1)
        self.pulses = {wire: PulseInput(self.now_ns) for wire in self.signs}
        self._mark = self._received_mark = 0

    def segment(self, train: PulseTrain) -> None:
        """Begin a segment, which replaces the one before."""
        start_hz, before = self._settings.start_hz, self._followed.get(train.name)
        self._mark_down(max(self.now_ns - 1, self._marked_ns))
        if before is not None:
            before = before.cut(train.start_ns)
            self._followed = self._followed | {train.name: before}
        self._judge_ends(min(train.start_ns, self.now_ns))  # an end in the future is not over yet
        if train.count != 0 and jump_hz(before, train, self.now_ns) > start_hz:
            self._fall_out()
        self._receive(train)

    def silence(self) -> None:
        """Judge the ends of segments that none has followed for `SILENCE_NS`."""
        self._judge_ends(self.now_ns - SILENCE_NS + 1)

    def _judge_ends(self, before_ns: int) -> None:
        for wire, followed in self._followed.items():
            stopped_ns = followed.stops_short_ns(self._settings.start_hz)
            if self.is_following and stopped_ns is not None and stopped_ns < before_ns:
                self._stop_short(wire)

    def edge(self, signal: Signal) -> None:
        """Set the level of a wire that carries single edges."""
        wire, pulses = signal.name, self.pulses[signal.name]
        if signal.value and not pulses.level_at(self.now_ns):
            before_hz = self._edge_hz(wire)
            rate = copy(self._rates[wire])
            jump = abs(rate.edge(self.now_ns, pulses.is_reverse) - before_hz)
            self._rates = self._rates | {wire: rate}
            if jump > self._settings.start_hz:
                self._mark_down(self.now_ns)
                self._fall_out()
        self._receive(signal)

    def _receive(self, signal: Signal) -> None:
        pulses = self.pulses[signal.name].copy()
        pulses.receive(signal, self.now_ns)
        self.pulses = self.pulses | {signal.name: pulses}

    def turn_round(self, is_reverse: bool) -> None:
        """Set the direction of single edges."""
        self.pulses = {wire: pulses.copy() for wire, pulses in self.pulses.items()}
        for pulses in self.pulses.values():
            pulses.is_reverse = is_reverse

    def load(self, torque_nm: float) -> None:
        """Set the external torque at the load."""
        self.load_nm = torque_nm

    def enable(self, level: bool) -> None:
        if self.is_enabled and not level:
            self.is_alarm = self.is_in_step = False
        self.is_enabled = level

    def reset(self, level: bool) -> None:
        if level and not self.is_reset:
            self.is_alarm = self.is_in_step = False
        self.is_reset = level

    def fault(self, torque_left: float, is_jammed: bool, is_tripped: bool) -> None:
        """Set the effects of the faults: the part of the torque that is left, a blocked rotor, an alarm."""
        self._torque_left, self._is_jammed = torque_left, is_jammed
        self.is_alarm = self.is_alarm or is_tripped

    # ---- what is so at an instant from `now_ns` on, before `due_ns`

    def received_at(self, now_ns: int) -> int:
        return sum(pulses.received_at(now_ns) for pulses in self.pulses.values())

    def steps_at(self, now_ns: int) -> int:
        """Return the position of the motor in pulses."""
        return self._steps + (self._position_at(now_ns) - self._mark if self.is_following else 0)

    def lost_at(self, now_ns: int) -> int:
        """Return the pulses in both directions that the motor did not follow."""
        return self._lost + (0 if self.is_following else self.received_at(now_ns) - self._received_mark)

    def hz_at(self, now_ns: int) -> float:
        """Return the frequency of the pulses, negative backwards."""
        return sum(
            sign * (self.pulses[wire].speed_at(now_ns) or self._edge_hz(wire, now_ns))
            for wire, sign in self.signs.items()
        )

    @property
    def is_ready(self) -> bool:
        return self.is_enabled and not self.is_alarm

    def _position_at(self, now_ns: int) -> int:
        return sum(sign * self.pulses[wire].position_at(now_ns) for wire, sign in self.signs.items())

    def _edge_hz(self, wire: str, now_ns: int | None = None) -> float:
        if self.pulses[wire].present is not None:
            return 0.0
        return self._rates[wire].hz_at(self.now_ns if now_ns is None else now_ns)

    # ---- the motor

    def advance(self, to_ns: int) -> None:
        while self.due_ns is not None and self.due_ns <= to_ns:
            self.now_ns = self.due_ns
            self.look()
        self.now_ns = max(self.now_ns, to_ns)

    def look(self) -> None:
        """Judge the motor at the present instant, and find the next change."""
        now_ns = self.now_ns
        self._mark_down(now_ns)
        self.turning = list(self._turning())
        stops = list(self._stops())
        if self.is_ready and self.is_in_step and self._fails_ns() == now_ns:
            self._fall_out()
        for wire, due_ns in stops:
            if self.is_following and due_ns <= now_ns:
                self._stop_short(wire)
        if not self.is_in_step and not self.is_alarm and self._starts_ns() == now_ns:
            self.is_in_step = True
        if self._settings.detects_loss and self.is_enabled and not self.is_in_step:
            self.is_alarm = True
        self.is_following = self.is_ready and self.is_in_step
        if self.is_following:
            self._followed = self._followed | {train.name: Followed(train) for _, train in self.turning}
        else:
            self._followed = {}
        self.due_ns = min((when_ns for when_ns in self._changes(stops) if when_ns > now_ns), default=None)

    def _mark_down(self, now_ns: int) -> None:
        """Fold the pulses up to an instant into the position or the loss."""
        position, received = self._position_at(now_ns), self.received_at(now_ns)
        if self.is_following:
            self._steps += position - self._mark
        else:
            self._lost += received - self._received_mark
        self._mark, self._received_mark, self._marked_ns = position, received, now_ns

    def _fall_out(self) -> None:
        """Lose the pulses from the last mark on."""
        self.is_in_step = self.is_following = False
        self._followed = {}
        self.is_alarm = self.is_alarm or (self._settings.detects_loss and self.is_enabled)

    def _stop_short(self, wire: str) -> None:
        """Stay behind the last pulse of a wire whose pulses have stopped too fast."""
        followed = self._followed.get(wire)
        forward = followed.train.direction if followed else -1 if self.pulses[wire].is_reverse else 1
        self._fall_out()
        self._rates = self._rates | {wire: EdgeRate()}
        most = max(self._received_mark - self._lost, 0)
        behind = min(max(round(self._settings.pulses_per_turn / POLE_PAIRS), 1), most)
        self._steps -= self.signs[wire] * forward * behind
        self._lost += behind

    def _stops(self) -> Iterator[tuple[str, int]]:
        """Yield the wires whose pulses have surely ended, and the instants at which they have stopped too fast."""
        start_hz = self._settings.start_hz
        for wire in self.signs:
            followed, present, due_ns = self._followed.get(wire), self.pulses[wire].present, None
            if present is None:
                due_ns = self._rates[wire].drops_ns(start_hz)
            elif followed is not None and isinstance(present, PulseTrain) and present.count == 0:
                due_ns = followed.stops_short_ns(start_hz)
            if due_ns is not None:
                yield wire, due_ns

    def _turning(self) -> Iterator[tuple[int, PulseTrain]]:
        for wire, sign in self.signs.items():
            train = self.pulses[wire].present
            if isinstance(train, PulseTrain) and train.count != 0:
                end_ns = train.end_ns
                if end_ns is None or end_ns > self.now_ns:
                    yield sign, train

    def _fails_ns(self) -> int | None:
        """Return when the motor falls out of step, if nothing changes; None if it does not."""
        now_ns, left = self.now_ns, self._torque_left
        load_nm = (self._settings.load_torque_nm + self.load_nm) / self._settings.gear_ratio
        if self._settings.reversed:
            load_nm = -load_nm
        if not self._motor.holds(load_nm, left):
            return now_ns
        if self.turning and self._is_jammed:
            return max(now_ns, min(train.start_ns for _, train in self.turning))
        times = []
        for sign, train in self.turning:
            limit_hz = self._motor.limit_hz(sign * train.direction, float(train.rate), load_nm, left)
            when_ns = passes_ns(train, limit_hz, max(now_ns, train.start_ns))
            times += [] if when_ns is None else [when_ns]
        for wire, sign in self.signs.items():
            hz = self._edge_hz(wire)
            if hz and abs(hz) > self._motor.limit_hz(sign * (1 if hz > 0 else -1), 0.0, load_nm, left):
                return now_ns
        return min(times, default=None)

    def _starts_ns(self) -> int | None:
        """Return when the pulses are slow enough for the motor to be in step again; None if they never are."""
        now_ns, start_hz = self.now_ns, self._settings.start_hz
        if self._fails_ns() == now_ns or any(abs(self._edge_hz(wire)) > start_hz for wire in self.signs):
            return None
        times = [falls_to_ns(train, start_hz, now_ns) for _, train in self.turning]
        return now_ns if not times else None if None in times else max(time for time in times if time is not None)

    def _changes(self, stops: list[tuple[str, int]]) -> Iterator[int]:
        for _, train in self.turning:
            yield from (when_ns for when_ns in (train.start_ns, train.end_ns) if when_ns is not None)
        if self.is_following:
            yield from (due_ns for _, due_ns in stops)
        expected = self._fails_ns() if self.is_following else None if self.is_alarm else self._starts_ns()
        if expected is not None:
            yield expected
