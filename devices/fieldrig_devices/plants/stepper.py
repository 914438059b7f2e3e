"""A stepper: drive with pulse inputs, enable, alarm and ready contact, and a stepping motor with its load.

While the motor is in step, its load is exactly where the pulses say.  It falls out of step when load, rate or frequency
ask for more torque than it has (`stepper_model`), or the frequency jumps.  From then on pulses are lost until the drive
is reset, or, if it does not notice, until the frequency is low enough to start with.  Pulses that stop too fast leave
the rotor one pole pair behind, where it locks in again.  Every pulse is accounted for:

    sent = received + missed       received = steps + lost, in each direction

All of this goes by the instants of the pulses, and not by those at which the messages about them arrive: in real time
a segment of a few pulses is over before the message about the next one is here (`stepper_state`, `replay`).  What was
shown in the meantime, such as an alarm, is taken back if a late message says otherwise.

A single edge has no rate, so of single edges only the frequency and its jumps are judged.  How far a rotor swings when
its pulses stop depends on its load; one pole pair of a motor with 50 of them is the least that it can miss.
Left out: microstep errors, the current at standstill, and a load that turns the motor while it is out of step.
"""

from collections.abc import Callable, Collection, Mapping
from dataclasses import replace
from functools import partial
from math import isfinite, tau
from typing import Any, ClassVar, Final, NamedTuple

from fieldrig.clock import Alarm, Clock
from fieldrig.device import Device, Point, Value
from fieldrig.faults.faults import Fault, Faults
from fieldrig.faults.injected import InjectedFaults
from fieldrig.front import Front
from fieldrig.link import Link
from fieldrig.points.checks import number_in, truth_in
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.wires import Motion, Signal
from fieldrig_devices.plants import front
from fieldrig_devices.plants.replay import Replay
from fieldrig_devices.plants.stepper_model import Followed
from fieldrig_devices.plants.stepper_settings import MODELS, Jam, StepperSettings, Trip, Weak
from fieldrig_devices.plants.stepper_state import SILENCE_NS, StepperState
from fieldrig_devices.pulses.pulse_input import PulseInput

LARGEST_LOAD_NM: Final = 1e6


class _Silence(NamedTuple):
    when_ns: int
    """The instant from which on a sender that sent nothing since counts as at rest."""
    believed_ns: int
    """The instant at which that is believed: later if the last message was late, as then the next one may be."""


class Stepper(Device):
    """A stepper as a device of a rig."""

    about = "a stepper: drive with pulse inputs, motor with pull-out torque, and load (a plant, on wires)"
    trouble_keys: ClassVar[Collection[str]] = ("alarm", "lost")
    fault_models: ClassVar[Mapping[str, type[Any]]] = MODELS

    def __init__(self, clock: Clock, name: str, settings: StepperSettings, wires: Link[Signal]) -> None:
        self._clock, self._settings, self._wires = clock, settings, wires
        self.injected = self._faults = InjectedFaults[Fault[Any]](
            clock, MODELS, Faults(Fault), on_change=self._on_faults
        )
        self._replay = Replay(StepperState(settings, clock.now_ns()))
        self._rad_per_pulse = tau / settings.pulses_per_turn / settings.gear_ratio * (-1 if settings.reversed else 1)
        self._names = settings.outputs(name)
        self._published: dict[str, Signal] = {}
        self._silent: dict[str, _Silence] = {}
        """The silences after the last segments, by wire."""
        self._timer = Alarm(clock)
        self._handlers = {
            settings.wire_for(name, "load_torque"): self._on_load_torque,
            settings.wire_for(name, "reset"): self._on_reset,
        }
        for wire, handler in ((settings.enable_wire, self._on_enable), (settings.direction_wire, self._on_direction)):
            if wire is not None:
                self._handlers[wire] = handler
        wires.on_receive(self._on_signal, (*self._state.signs, *self._handlers))

    def start(self) -> None:
        state = self._state
        state.advance(self._clock.now_ns())
        state.switch_on()
        state.look()
        self._replay = Replay(state)
        self._silent.clear()
        self._go_on()

    def front(self) -> Front:
        return front.stepper()

    def points(self) -> Mapping[str, Point]:
        now_ns, scale = self._clock.now_ns, self._rad_per_pulse
        pulses = self._account
        return {
            "position": Point(lambda: self._state.steps_at(now_ns()) * scale, None, "rad", "of the load"),
            "speed": Point(
                lambda: self._state.hz_at(now_ns()) * scale if self._state.is_following else 0.0,
                None, "rad/s", "of the load",
            ),
            "steps": Point(lambda: self._state.steps_at(now_ns()), None, "pulse", "position of the motor"),
            "frequency": Point(lambda: self._state.hz_at(now_ns()), None, "Hz", "of the pulses; negative backwards"),
            "sent": Point(lambda: sum(one.sent_at(now_ns()) for one in pulses()), None, "pulse", "by the senders"),
            "received": Point(lambda: self._state.received_at(now_ns()), None, "pulse", "in both directions"),
            "missed": Point(
                lambda: sum(one.missed for one in pulses()), None, "pulse", "sent, but never received"
            ),
            "surplus": Point(lambda: sum(one.surplus for one in pulses()), None, "pulse", "received, but not sent"),
            "restarts": Point(lambda: sum(one.restarts for one in pulses()), None, "", "senders that started again"),
            "lost": Point(
                lambda: self._state.lost_at(now_ns()), None, "pulse", "received, but not followed by the motor"
            ),
            "in_step": Point(lambda: self._state.is_in_step, None, "", "the motor follows, or would"),
            "enabled": Point(lambda: self._state.is_enabled, None, "", "by its input"),
            "alarm": Point(lambda: self._state.is_alarm, None, "", "of the drive"),
            "ready": Point(lambda: self._state.is_ready, None, "", "the ready contact"),
            "reset": Point(
                lambda: self._state.is_reset, self._write_reset, "", "the reset input; its rising edge clears the alarm"
            ),
            "load_torque": Point(
                lambda: self._state.load_nm, self._write_load_torque,
                "N m", "external, at the load; positive pulls down",
            ),
        }  # fmt: skip

    @property
    def _state(self) -> StepperState:
        return self._replay.state

    def _account(self) -> list[PulseInput]:
        return list(self._state.pulses.values())

    # ---- inputs

    def _on_signal(self, signal: Signal) -> None:
        if not isfinite(signal.value):
            return
        if signal.name in self._state.signs:
            self._on_pulses(signal)
        else:
            self._handlers[signal.name](float(signal.value))

    def _on_pulses(self, signal: Signal) -> None:
        if isinstance(signal, PulseTrain):
            if signal == self._state.pulses[signal.name].present:
                return
            self._on_segment(signal)
        elif type(signal) is Signal:
            self._silent.pop(signal.name, None)
            self._replay.happen(self._clock.now_ns(), partial(StepperState.edge, signal=signal))
        else:
            return
        self._go_on()

    def _on_segment(self, train: PulseTrain) -> None:
        now_ns, before = self._clock.now_ns(), self._silent.pop(train.name, None)
        if before is not None and before.when_ns < train.start_ns and before.when_ns <= now_ns:
            self._replay.happen(before.when_ns, StepperState.silence)
        self._replay.begin(min(train.start_ns, now_ns), partial(StepperState.segment, train=train), train.name)
        stopped_ns = Followed(train).stops_short_ns(self._settings.start_hz) if train.count != 0 else None
        if stopped_ns is not None:
            silent_ns = stopped_ns + SILENCE_NS
            self._silent[train.name] = _Silence(silent_ns, max(silent_ns, now_ns + SILENCE_NS))

    def _happen(self, change: Callable[[StepperState], None]) -> None:
        self._replay.happen(self._clock.now_ns(), change)
        self._go_on()

    def _on_direction(self, level: float) -> None:
        self._happen(partial(StepperState.turn_round, is_reverse=not level))

    def _on_load_torque(self, torque_nm: float) -> None:
        self._happen(partial(StepperState.load, torque_nm=min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM)))

    def _write_load_torque(self, value: Value) -> None:
        self._on_load_torque(float(number_in(value, unit="N m")))

    def _on_enable(self, level: float) -> None:
        self._happen(partial(StepperState.enable, level=bool(level)))

    def _on_reset(self, level: float) -> None:
        self._happen(partial(StepperState.reset, level=bool(level)))

    def _write_reset(self, value: Value) -> None:
        """Press the reset button of the drive, or release it."""
        self._on_reset(float(truth_in(value)))

    def _on_faults(self) -> None:
        faults = self._faults
        left = min((fault.percent for fault in faults.active(Weak)), default=100.0) / 100
        is_jammed, is_tripped = (faults.first(kind) is not None for kind in (Jam, Trip))
        self._happen(partial(StepperState.fault, torque_left=left, is_jammed=is_jammed, is_tripped=is_tripped))

    # ---- outputs

    def _go_on(self) -> None:
        """Go on to the present instant, publish what changed, and wait for the next change."""
        now_ns = self._clock.now_ns()
        for wire, silence in list(self._silent.items()):
            if silence.believed_ns <= now_ns:
                del self._silent[wire]
                self._replay.happen(silence.when_ns, StepperState.silence)
        self._state.advance(now_ns)
        self._publish()
        due = [silence.believed_ns for silence in self._silent.values()]
        due += [] if self._state.due_ns is None else [self._state.due_ns]
        self._timer.at(min(due, default=None), self._go_on)

    def _publish(self) -> None:
        now_ns, scale, state = self._clock.now_ns(), self._rad_per_pulse, self._state
        speed, rate = 0.0, 0.0
        if state.is_following:
            for sign, train in state.turning:
                speed += sign * train.speed_at(now_ns) * scale
                rate += sign * train.direction * float(train.rate) * scale if train.start_ns <= now_ns else 0.0
        wire = self._names["position_wire"]
        self._send(Motion(wire, state.steps_at(now_ns) * scale, "rad", now_ns, speed, rate))
        self._send(Signal(self._names["ready_wire"], state.is_ready))
        self._send(Signal(self._names["alarm_wire"], state.is_alarm))

    def _send(self, signal: Signal) -> None:
        before = self._published.get(signal.name)
        if isinstance(signal, Motion) and isinstance(before, Motion) and not signal.is_moving:
            signal = replace(signal, time_ns=before.time_ns) if signal.value == before.value else signal
        if signal != before:
            self._published[signal.name] = signal
            self._wires.send(signal)
