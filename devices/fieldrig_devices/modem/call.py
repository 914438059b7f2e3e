"""The telephone side of a modem: dialling, answering, the handshake, and the loss of the carrier.

Source: ITU-T V.250, 6.3 (dialling, answering, time-outs of S6 to S10), V.25 (silence before an answer).  A result
leaves by `Events.result`.
"""

from collections.abc import Callable
from dataclasses import dataclass
from enum import Enum
from typing import Final

from fieldrig.clock import MS, Alarm, Clock, S
from fieldrig.link import Link
from fieldrig_bus.telephone.handshake import Handshake
from fieldrig_bus.telephone.message import Carrier, Dial, Heard, Hook, Offer, Ready, TelephoneMessage, Tone
from fieldrig_bus.telephone.modulation import Agreed
from fieldrig_bus.telephone.pump import Pump
from fieldrig_devices.modem import results
from fieldrig_devices.modem.dial_string import Digits, Step, Wait, duration_ns
from fieldrig_devices.modem.results import Result

DIAL_TONE_NS: Final = 1 * S
"""How long a dial tone must be heard."""
NO_DIAL_TONE_NS: Final = 5 * S
"""How long the first dial tone is awaited; a `W` waits for the time of S7."""
BUSY_TONE_NS: Final = 2 * S
QUIET_NS: Final = 5 * S
FLASH_NS: Final = 500 * MS
BEFORE_ANSWER_NS: Final = 2 * S
NEVER: Final = 255
"""The value of S10 with which the loss of the carrier does not end a call."""


class CallState(Enum):
    IDLE = "idle"
    SEIZED = "seized"
    DIALLING = "dialling"
    WAITING = "waiting for a carrier"
    CONNECTED = "connected"


@dataclass(frozen=True)
class Rules:
    """The settings that a call follows, as they are when it is asked for."""

    offer: Offer
    training_ns: int
    register: Callable[[int], int]
    is_blind: bool
    """Digits are dialled without a dial tone."""
    detects_busy: bool


@dataclass(frozen=True)
class Events:
    result: Callable[[Result], None]
    connected: Callable[[Agreed], None]
    over: Callable[[], None]
    """The line is free again."""


class Call:
    def __init__(self, clock: Clock, link: Link[TelephoneMessage], events: Events) -> None:
        self._clock, self._link, self._events = clock, link, events
        self.pump = Pump(link, clock)
        self.state = CallState.IDLE
        self.agreed: Agreed | None = None
        self._rules: Rules | None = None
        self._steps: list[Step] = []
        self._stays = self._is_answering = False
        self._tone = Tone.SILENCE
        self._handshake: Handshake | None = None
        self._limit = Alarm(self._clock)
        self._next = Alarm(self._clock)

    @property
    def is_establishing(self) -> bool:
        return self.state in (CallState.DIALLING, CallState.WAITING)

    # ---- what commands ask for

    def dial(self, rules: Rules, steps: list[Step], stays: bool) -> None:
        self._rules, self._steps, self._stays, self._is_answering = rules, list(steps), stays, False
        was_off, self.state = self.state is CallState.SEIZED, CallState.DIALLING
        if was_off:
            self._step()
            return
        self._tone = Tone.SILENCE
        self._link.send(Hook(True))
        if rules.is_blind:
            self._then(rules.register(6) * S, self._step)
        else:
            self._await_dial_tone(NO_DIAL_TONE_NS)

    def answer(self, rules: Rules) -> None:
        self._rules, self._is_answering = rules, True
        if self.state is CallState.IDLE:
            self._link.send(Hook(True))
        self._wait_for_carrier()
        self._then(BEFORE_ANSWER_NS, self._begin_answer)

    def seize(self) -> None:
        if self.state is CallState.IDLE:
            self.state = CallState.SEIZED
            self._link.send(Hook(True))

    def hang_up(self) -> None:
        if self.state is CallState.IDLE:
            return
        self.state, self.agreed = CallState.IDLE, None
        self._stop_timers()
        if self._handshake is not None:
            self._handshake.stop()
            self._handshake = None
        self.pump.start(Carrier(0))
        self._link.send(Hook(False))
        self._events.over()

    def fail(self, result: Result) -> None:
        self.hang_up()
        self._events.result(result)

    # ---- what the line says

    def hear(self, message: Heard | Offer | Carrier | Ready) -> None:
        match message:
            case Heard(tone=tone):
                self._on_tone(tone)
            case Offer() if self._handshake is not None:
                self._handshake.hear(message)
            case Carrier() if self.state is CallState.CONNECTED:
                self._on_carrier(message)
            case Carrier() if self._handshake is not None:
                self._handshake.hear(message)
            case Ready(is_ready=is_ready) if self.agreed is not None and self.agreed.is_corrected:
                self.pump.hold(not is_ready)

    def _on_tone(self, tone: Tone) -> None:
        before, self._tone = self._tone, tone
        rules = self._rules
        if self.state is CallState.CONNECTED:
            if tone in (Tone.BUSY, Tone.DIAL):  # the dial tone: the exchange has started again
                self.fail(results.NO_CARRIER)
        elif not self.is_establishing or rules is None:
            return
        elif tone is Tone.BUSY and (self._is_answering or (self._handshake and self._handshake.has_heard)):
            self.fail(results.NO_CARRIER)
        elif tone is Tone.BUSY and rules.detects_busy:
            self._then(BUSY_TONE_NS, lambda: self.fail(results.BUSY))
        elif self._awaits(Wait.TONE):
            self._next.stop()
            if tone is Tone.DIAL:
                self._then(DIAL_TONE_NS, self._step_past_wait)
        elif self._awaits(Wait.QUIET) and before is Tone.RINGING and tone is Tone.SILENCE:
            self._then(QUIET_NS, self._step_past_wait)

    def _on_carrier(self, carrier: Carrier) -> None:
        assert self._rules is not None
        lost_ns = self._rules.register(10) * 100 * MS
        if carrier.bps:
            self._next.stop()
        elif self._rules.register(10) != NEVER:
            self._then(lost_ns, lambda: self.fail(results.NO_CARRIER))

    # ---- the steps of a dial string

    def _step(self) -> None:
        rules, step = self._rules, self._steps[0] if self._steps else None
        assert rules is not None
        match step:
            case None if self._stays:
                self._stop_timers()
                self.state = CallState.SEIZED
                self._events.result(results.OK)
            case None:
                self._wait_for_carrier()
            case Digits():
                self._then(duration_ns(step, rules.register(11)), self._send_digits)
            case Wait.PAUSE:
                self._then(rules.register(8) * S, self._step_past)
            case Wait.TONE:
                self._await_dial_tone(rules.register(7) * S)
            case Wait.QUIET:
                self._limit_to(rules.register(7) * S, results.NO_ANSWER)
            case Wait.FLASH:
                self._link.send(Hook(False))
                self._then(FLASH_NS, self._seize_again)

    def _step_past(self) -> None:
        del self._steps[:1]
        self._step()

    def _step_past_wait(self) -> None:
        self._limit.stop()
        self._step_past()

    def _send_digits(self) -> None:
        step = self._steps[0]
        assert isinstance(step, Digits)
        self._tone = Tone.SILENCE  # the digits end the dial tone
        self._link.send(Dial(step.digits))
        self._step_past()

    def _seize_again(self) -> None:
        self._link.send(Hook(True))
        self._step_past()

    def _await_dial_tone(self, limit_ns: int) -> None:
        if not self._awaits(Wait.TONE):
            self._steps.insert(0, Wait.TONE)
        self._limit_to(limit_ns, results.NO_DIALTONE)
        if self._tone is Tone.DIAL:
            self._then(DIAL_TONE_NS, self._step_past_wait)

    def _awaits(self, wait: Wait) -> bool:
        return self.state is CallState.DIALLING and self._steps[:1] == [wait]

    # ---- carrier

    def _wait_for_carrier(self) -> None:
        rules = self._rules
        assert rules is not None
        self.state = CallState.WAITING
        self._handshake = Handshake(
            self._clock, self._link, rules.offer, rules.training_ns, self._on_connected, self._on_mismatch
        )
        self._limit_to(rules.register(7) * S, results.NO_CARRIER)

    def _begin_answer(self) -> None:
        if self._handshake is not None:
            self._handshake.answer()

    def _on_mismatch(self) -> None:
        self.fail(results.NO_CARRIER)

    def _on_connected(self, agreed: Agreed, theirs: Carrier) -> None:
        if self.state is not CallState.WAITING:
            return
        self._stop_timers()
        self.state, self.agreed = CallState.CONNECTED, agreed
        self.pump.start(Carrier(agreed.bps, agreed.is_corrected, theirs.is_paced))
        self._events.connected(agreed)

    # ---- time

    def _then(self, pause_ns: int, action: Callable[[], None]) -> None:
        self._next.after(pause_ns, action)

    def _limit_to(self, limit_ns: int, result: Result) -> None:
        self._limit.after(limit_ns, lambda: self.fail(result))

    def _stop_timers(self) -> None:
        self._limit.stop()
        self._next.stop()
