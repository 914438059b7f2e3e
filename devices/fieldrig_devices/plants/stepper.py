"""A stepper: drive with pulse inputs, enable, alarm and ready contact, and a stepping motor with its load.

While the motor is in step, its load is exactly where the pulses say.  It falls out of step when load, rate or frequency
ask for more torque than it has (`stepper_model`), or the frequency jumps.  From then on pulses are lost until the drive
is reset, or, if it does not notice, until the frequency is low enough to start with.  Pulses that stop too fast leave
the rotor one pole pair behind, where it locks in again.  Every pulse is accounted for:

    sent = received + missed       received = steps + lost, in each direction

A single edge has no rate, so of single edges only the frequency and its jumps are judged.  How far a rotor swings when
its pulses stop depends on its load; one pole pair of a motor with 50 of them is the least that it can miss.
Left out: microstep errors, the current at standstill, and a load that turns the motor while it is out of step.
"""

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from math import isfinite, tau
from typing import Any, ClassVar, Final

from fieldrig.clock import MS, Alarm, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.faults import Fault, Faults
from fieldrig.injected_faults import InjectedFaults
from fieldrig.link import Link
from fieldrig.point_values import number_in, truth_in
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants.stepper_model import Motor, PullOut, falls_to_ns, jump_hz, passes_ns, stops_short_ns
from fieldrig_devices.plants.stepper_settings import MODELS, Jam, StepperSettings, Trip, Weak
from fieldrig_devices.pulses.edge_rate import EdgeRate
from fieldrig_devices.pulses.pulse_input import PulseInput

LARGEST_LOAD_NM: Final = 1e6
ARRIVAL_NS: Final = 20 * MS
"""Time that the next pulses may be on their way before the motor counts as stopped.  In real time a segment of a few
pulses is over before the message about the next one is here."""
POLE_PAIRS: Final = 50
"""The pole pairs of the usual hybrid stepper with 200 full steps, which locks in again at every fourth of them."""


class Stepper(Device):
    """A stepper as a device of a rig."""

    about = "a stepper: drive with pulse inputs, motor with pull-out torque, and load (a plant, on wires)"
    trouble_keys: ClassVar[Collection[str]] = ("alarm", "lost")
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: StepperSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self._motor = Motor(
            PullOut(settings.pull_out), settings.pulses_per_turn, settings.inertia_kg_m2, settings.coulomb_nm,
            settings.highest_hz,
        )  # fmt: skip
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        now_ns = clock.now_ns()
        self._signs = {settings.pulse_wire: 1}
        if settings.ccw_wire is not None:
            self._signs[settings.ccw_wire] = -1
        self._pulses = {wire: PulseInput(now_ns) for wire in self._signs}
        self._rates = {wire: EdgeRate() for wire in self._signs}
        self._rad_per_pulse = tau / settings.pulses_per_turn / settings.gear_ratio * (-1 if settings.reversed else 1)
        self._load_nm = 0.0  # external, at the load
        self._is_enabled = settings.enable_wire is None
        self._is_in_step, self._is_alarm, self._is_reset = True, False, False
        self._steps = self._lost = 0
        """Position of the motor, and pulses in both directions that it did not follow, up to the marks."""
        self._mark = self._received_mark = 0
        """Position and number of received pulses from which on `_steps` and `_lost` go on."""
        self._is_following = False
        self._followed: dict[str, PulseTrain] = {}
        """The segments that the motor turned with."""
        self._names = settings.outputs(name)
        self._published: dict[str, Signal] = {}
        self._timer = Alarm(self._clock)
        self._handlers = {
            settings.load_torque_wire or f"{name}.load_torque": self._on_load_torque,
            settings.reset_wire or f"{name}.reset": self._on_reset,
        }
        for wire, handler in ((settings.enable_wire, self._on_enable), (settings.direction_wire, self._on_direction)):
            if wire is not None:
                self._handlers[wire] = handler
        wires.on_receive(self._on_signal, (*self._signs, *self._handlers))

    def start(self) -> None:
        now_ns = self._clock.now_ns()
        self._pulses = {wire: PulseInput(now_ns) for wire in self._signs}
        self._look()

    def points(self) -> Mapping[str, Point]:
        now_ns, scale = self._clock.now_ns, self._rad_per_pulse
        pulses = self._account
        return {
            "position": Point(lambda: self._steps_at(now_ns()) * scale, None, "rad", "of the load"),
            "speed": Point(lambda: self._hz() * scale if self._is_following else 0.0, None, "rad/s", "of the load"),
            "steps": Point(lambda: self._steps_at(now_ns()), None, "pulse", "position of the motor"),
            "frequency": Point(self._hz, None, "Hz", "of the pulses; negative backwards"),
            "sent": Point(lambda: sum(one.sent_at(now_ns()) for one in pulses()), None, "pulse", "by the senders"),
            "received": Point(self._received, None, "pulse", "in both directions"),
            "missed": Point(
                lambda: sum(one.missed for one in pulses()), None, "pulse", "sent, but never received"
            ),
            "surplus": Point(lambda: sum(one.surplus for one in pulses()), None, "pulse", "received, but not sent"),
            "restarts": Point(lambda: sum(one.restarts for one in pulses()), None, "", "senders that started again"),
            "lost": Point(lambda: self._lost_at(), None, "pulse", "received, but not followed by the motor"),
            "in_step": Point(lambda: self._is_in_step, None, "", "the motor follows, or would"),
            "enabled": Point(lambda: self._is_enabled, None, "", "by its input"),
            "alarm": Point(lambda: self._is_alarm, None, "", "of the drive"),
            "ready": Point(self._is_ready, None, "", "the ready contact"),
            "reset": Point(
                lambda: self._is_reset, self._write_reset, "", "the reset input; its rising edge clears the alarm"
            ),
            "load_torque": Point(
                lambda: self._load_nm, self._write_load_torque, "N m", "external, at the load; positive pulls down"
            ),
        }  # fmt: skip

    # ---- inputs

    def _on_signal(self, signal: Signal) -> None:
        if not isfinite(signal.value):
            return
        if signal.name in self._signs:
            self._on_pulses(signal)
        else:
            self._handlers[signal.name](float(signal.value))

    def _on_pulses(self, signal: Signal) -> None:
        wire, now_ns = signal.name, self._clock.now_ns()
        pulses = self._pulses[wire]
        if isinstance(signal, PulseTrain):
            if signal == pulses.present:
                return
            jump = jump_hz(self._followed.get(wire), signal)
        elif type(signal) is Signal:
            before_hz = self._edge_hz(wire)
            jump = abs(self._rates[wire].edge(now_ns, pulses.is_reverse) - before_hz) if signal.value else 0.0
        else:
            return
        if jump > self._settings.start_hz:
            self._fall_out()
        pulses.receive(signal, now_ns)
        if self._is_following and isinstance(signal, PulseTrain) and signal.count != 0:
            self._followed[wire] = signal  # also one that is over when it arrives, as short ones are in real time
        self._look()

    def _on_direction(self, level: float) -> None:
        for pulses in self._pulses.values():
            pulses.is_reverse = not level

    def _on_load_torque(self, torque_nm: float) -> None:
        self._load_nm = min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM)
        self._look()

    def _write_load_torque(self, value: Value) -> None:
        self._on_load_torque(float(number_in(value, unit="N m")))

    def _on_enable(self, level: float) -> None:
        if self._is_enabled and not level:
            self._is_alarm = self._is_in_step = False
        self._is_enabled = bool(level)
        self._look()

    def _on_reset(self, level: float) -> None:
        if level and not self._is_reset:
            self._is_alarm = self._is_in_step = False
        self._is_reset = bool(level)
        self._look()

    def _write_reset(self, value: Value) -> None:
        """Press the reset button of the drive, or release it."""
        self._on_reset(float(truth_in(value)))

    def _on_faults(self) -> None:
        if self._faults.first(Trip) is not None:
            self._is_alarm = True
        self._look()

    # ---- the motor

    def _account(self) -> list[PulseInput]:
        return list(self._pulses.values())

    def _position(self) -> int:
        """The position of the pulses received."""
        now_ns = self._clock.now_ns()
        return sum(sign * self._pulses[wire].position_at(now_ns) for wire, sign in self._signs.items())

    def _received(self) -> int:
        return sum(pulses.received_at(self._clock.now_ns()) for pulses in self._pulses.values())

    def _hz(self) -> float:
        now_ns = self._clock.now_ns()
        return sum(
            sign * (self._pulses[wire].speed_at(now_ns) or self._edge_hz(wire)) for wire, sign in self._signs.items()
        )

    def _edge_hz(self, wire: str) -> float:
        is_single = self._pulses[wire].present is None
        return self._rates[wire].hz_at(self._clock.now_ns()) if is_single else 0.0

    def _steps_at(self, now_ns: int) -> int:
        return self._steps + (self._position() - self._mark if self._is_following else 0)

    def _lost_at(self) -> int:
        return self._lost + (0 if self._is_following else self._received() - self._received_mark)

    def _is_ready(self) -> bool:
        return self._is_enabled and not self._is_alarm

    def _mark_down(self) -> None:
        """Fold the pulses up to now into the position or the loss."""
        now_ns = self._clock.now_ns()
        self._steps, self._lost = self._steps_at(now_ns), self._lost_at()
        self._mark, self._received_mark = self._position(), self._received()

    def _fall_out(self) -> None:
        self._mark_down()
        self._is_in_step = self._is_following = False
        self._followed.clear()
        self._is_alarm = self._is_alarm or (self._settings.detects_loss and self._is_enabled)

    def _look(self) -> None:
        """Judge the motor at the present instant, publish what changed, and wait for the next change."""
        now_ns = self._clock.now_ns()
        self._mark_down()
        if self._is_ready() and self._is_in_step and self._fails_ns() == now_ns:
            self._fall_out()
        if self._is_following:
            self._judge_stops(now_ns)
        if not self._is_in_step and not self._is_alarm and self._starts_ns() == now_ns:
            self._is_in_step = True
        if self._settings.detects_loss and self._is_enabled and not self._is_in_step:
            self._is_alarm = True
        self._is_following = self._is_ready() and self._is_in_step
        if not self._is_following:
            self._followed.clear()
        self._followed |= {train.name: train for _, train in self._trains() if self._is_following}
        self._publish()
        due = [when_ns for when_ns in self._changes() if when_ns > now_ns]
        self._timer.at(min(due), self._look) if due else None

    def _judge_stops(self, now_ns: int) -> None:
        """Lose steps on each wire whose pulses have stopped too fast."""
        for wire, due_ns in list(self._stops()):
            if due_ns <= now_ns:
                forward = self._hz_sign(wire)
                self._fall_out()
                self._rates[wire].end()
                behind = min(max(round(self._settings.pulses_per_turn / POLE_PAIRS), 1), self._received())
                self._steps -= self._signs[wire] * forward * behind
                self._lost += behind

    def _hz_sign(self, wire: str) -> int:
        followed = self._followed.get(wire)
        return followed.direction if followed is not None else -1 if self._pulses[wire].is_reverse else 1

    def _stops(self) -> Iterator[tuple[str, int]]:
        """Yield the wires whose pulses have ended, and the instants at which they have stopped too fast."""
        start_hz, moving = self._settings.start_hz, {train.name for _, train in self._trains()}
        for wire in self._signs:
            followed, due_ns = self._followed.get(wire), None
            if self._pulses[wire].present is None:
                due_ns = self._rates[wire].drops_ns(start_hz)
            elif followed is not None and wire not in moving:
                stopped_ns = stops_short_ns(followed, start_hz)
                due_ns = None if stopped_ns is None else stopped_ns + ARRIVAL_NS
            if due_ns is not None:
                yield wire, due_ns

    def _trains(self) -> list[tuple[int, PulseTrain]]:
        """The segments that are not over, each with the sign of its input."""
        now_ns, found = self._clock.now_ns(), []
        for wire, sign in self._signs.items():
            train = self._pulses[wire].present
            if isinstance(train, PulseTrain) and train.count != 0:
                end_ns = train.end_ns
                if end_ns is None or end_ns > now_ns:
                    found.append((sign, train))
        return found

    def _torque_left(self) -> float:
        return min((fault.percent for fault in self._faults.active(Weak)), default=100.0) / 100

    def _fails_ns(self) -> int | None:
        """Return when the motor falls out of step, if nothing changes; None if it does not."""
        now_ns, left = self._clock.now_ns(), self._torque_left()
        load_nm = (self._settings.load_torque_nm + self._load_nm) / self._settings.gear_ratio
        if self._settings.reversed:
            load_nm = -load_nm
        if not self._motor.holds(load_nm, left):
            return now_ns
        trains = self._trains()
        if trains and self._faults.first(Jam) is not None:
            return max(now_ns, min(train.start_ns for _, train in trains))
        times = []
        for sign, train in trains:
            limit_hz = self._motor.limit_hz(sign * train.direction, float(train.rate), load_nm, left)
            when_ns = passes_ns(train, limit_hz, max(now_ns, train.start_ns))
            times += [] if when_ns is None else [when_ns]
        for wire, sign in self._signs.items():
            hz = self._edge_hz(wire)
            if hz and abs(hz) > self._motor.limit_hz(sign * (1 if hz > 0 else -1), 0.0, load_nm, left):
                return now_ns
        return min(times, default=None)

    def _starts_ns(self) -> int | None:
        """Return when the pulses are slow enough for the motor to be in step again; None if they never are."""
        now_ns, start_hz = self._clock.now_ns(), self._settings.start_hz
        if self._fails_ns() == now_ns or any(abs(self._edge_hz(wire)) > start_hz for wire in self._signs):
            return None
        times = [falls_to_ns(train, start_hz, now_ns) for _, train in self._trains()]
        return now_ns if not times else None if None in times else max(time for time in times if time is not None)

    def _changes(self) -> list[int]:
        found = [end for _, train in self._trains() for end in (train.start_ns, train.end_ns) if end is not None]
        if self._is_following:
            found += [due_ns for _, due_ns in self._stops()]
        expected = self._fails_ns() if self._is_following else None if self._is_alarm else self._starts_ns()
        return found if expected is None else [*found, expected]

    # ---- outputs

    def _publish(self) -> None:
        now_ns, scale = self._clock.now_ns(), self._rad_per_pulse
        speed, rate = 0.0, 0.0
        if self._is_following:
            for sign, train in self._trains():
                speed += sign * train.speed_at(now_ns) * scale
                rate += sign * train.direction * float(train.rate) * scale if train.start_ns <= now_ns else 0.0
        wire = self._names["position_wire"]
        self._send(Motion(wire, self._steps_at(now_ns) * scale, "rad", now_ns, speed, rate))
        self._send(Signal(self._names["ready_wire"], self._is_ready()))
        self._send(Signal(self._names["alarm_wire"], self._is_alarm))

    def _send(self, signal: Signal) -> None:
        before = self._published.get(signal.name)
        if isinstance(signal, Motion) and isinstance(before, Motion) and not signal.is_moving:
            signal = replace(signal, time_ns=before.time_ns) if signal.value == before.value else signal
        if signal != before:
            self._published[signal.name] = signal
            self._wires.send(signal)
