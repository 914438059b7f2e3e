"""A pulse input: counts what arrives on one wire, and accounts for every pulse of the sender.

It counts the pulses that rise from its switching on, from segments, PWM signals or edges.  Each segment has the
sender's totals, so the account always closes:

    sent = received + missed - surplus

`missed` rose before the input was on, or in a segment that never arrived; `surplus` was counted although the sender
says that it did not send it.  A sender that starts again begins with totals of 0; then `restarts` is one more, and
`unconfirmed` has the pulses of its last segment, as no message says how many of them it sent.
"""

from copy import copy
from dataclasses import dataclass
from typing import Final, Self

from fieldrig.clock import NEVER_NS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_bus.signals.pwm import Pwm
from fieldrig_bus.wires import Signal

_MOST_OPEN: Final = 4


@dataclass(slots=True)
class _Segment:
    """A waveform of which the pulses within two instants count."""

    waveform: PulseTrain | Pwm
    after_ns: int
    until_ns: int = NEVER_NS
    at_start: int = 0
    """Rising edges at its beginning that its waveform does not count, or -1 if it counts one that is none."""

    def pulses_at(self, now_ns: int) -> int:
        return max(self._rises_at(min(now_ns, self.until_ns)) - self.early, 0)

    @property
    def early(self) -> int:
        """Number of pulses that rose before those that count."""
        return self._rises_at(min(self.after_ns, self.until_ns))

    def _rises_at(self, now_ns: int) -> int:
        return self.waveform.pulses_at(now_ns) + (self.at_start if now_ns >= self.waveform.start_ns else 0)

    @property
    def direction(self) -> int:
        return self.waveform.direction if isinstance(self.waveform, PulseTrain) else 1


class PulseInput:
    """The pulses of one wire.  Instants that are asked for are never before those of the signals received."""

    def __init__(self, since_ns: int) -> None:
        """`since_ns` is the instant at which the input is switched on."""
        self._before_ns = since_ns - 1
        self._segments: list[_Segment] = []  # the last one is the present one; those before begin their end later
        self._received = self._position = 0  # of the segments that are over, and of edges
        self._level: bool | None = None  # of the wire before the present segments; None if nothing came
        self.is_reverse = False
        """True if single edges count backwards; a segment says its direction itself."""
        self._missed = self._missed_position = 0
        self.surplus = 0
        """Number of pulses that counted although they were not sent."""
        self.restarts = 0
        self.unconfirmed = 0

    def copy(self) -> Self:
        """Return the same input, independent of this one."""
        other = copy(self)
        other._segments = [copy(segment) for segment in self._segments]
        return other

    @property
    def present(self) -> PulseTrain | Pwm | None:
        """The waveform that arrived last; None if there was none, or edges came since."""
        return self._segments[-1].waveform if self._segments else None

    @property
    def missed(self) -> int:
        """Number of pulses of the sender that did not count."""
        return self._missed + sum(segment.early for segment in self._segments)

    @property
    def missed_position(self) -> int:
        """The same, with backward ones as negative, so that `position_at` and this are the sender's position."""
        return self._missed_position + sum(segment.direction * segment.early for segment in self._segments)

    def receive(self, signal: Signal, now_ns: int) -> None:
        """Handle what arrived on the wire at `now_ns`."""
        if isinstance(signal, PulseTrain | Pwm):
            if signal != self.present:
                self._begin(signal, now_ns)
            return
        self._close(now_ns - 1, now_ns)
        level = bool(signal.value)
        if level and self._level is False:
            self._received += 1
            self._position += -1 if self.is_reverse else 1
        self._level = level

    def received_at(self, now_ns: int) -> int:
        """Return the number of pulses in both directions that counted up to and including `now_ns`."""
        return self._received + sum(segment.pulses_at(now_ns) for segment in self._segments)

    def position_at(self, now_ns: int) -> int:
        """Return the pulses forwards less those backwards that counted."""
        return self._position + sum(segment.direction * segment.pulses_at(now_ns) for segment in self._segments)

    def sent_at(self, now_ns: int) -> int:
        """Return how many pulses the sender has sent as far as is known."""
        return self.received_at(now_ns) + self.missed - self.surplus

    def speed_at(self, now_ns: int) -> float:
        """Return the frequency in Hz, negative backwards; 0 for single edges."""
        for segment in reversed(self._segments):
            waveform = segment.waveform
            if waveform.start_ns <= now_ns <= segment.until_ns:
                if isinstance(waveform, PulseTrain):
                    return waveform.speed_at(now_ns)
                return float(waveform.frequency) if 0 < waveform.value < 100 else 0.0
        return 0.0

    def level_at(self, now_ns: int) -> bool:
        """Return the level of the wire."""
        for segment in reversed(self._segments):
            if segment.waveform.start_ns <= now_ns:
                return segment.waveform.level_at(now_ns)
        return bool(self._level)

    def _begin(self, waveform: PulseTrain | Pwm, now_ns: int) -> None:
        before = self.present
        is_first = not self._segments and self._level is None
        if isinstance(waveform, PulseTrain):
            if isinstance(before, PulseTrain):
                self._follow(before, waveform, now_ns)
            elif is_first:
                self._miss(waveform.sent, int(waveform.value))
        at_start = 0 if is_first or isinstance(waveform, PulseTrain) else self._rise_between(waveform)
        self._close(waveform.start_ns - 1, now_ns)
        self._segments.append(_Segment(waveform, self._before_ns, at_start=at_start))

    def _rise_between(self, pwm: Pwm) -> int:
        """Return how many rising edges the beginning of a PWM has beside those of its cycles.

        Cycles that begin while the wire is high, as after a synchronisation, raise no edge; a duty of 100 % may.
        """
        is_rise = pwm.level_at(pwm.start_ns) and not self.level_at(pwm.start_ns - 1)
        return int(is_rise) - pwm.pulses_at(pwm.start_ns)

    def _follow(self, before: PulseTrain, train: PulseTrain, now_ns: int) -> None:
        """Compare the totals of the next segment with those that are expected."""
        end_ns = train.start_ns - 1
        if train.epoch_ns == before.epoch_ns:
            self._miss(train.sent - before.sent_at(end_ns), int(train.value) - before.at(end_ns))
            return
        self.restarts += 1
        self.unconfirmed += self._segments[-1].pulses_at(min(end_ns, now_ns))
        self._miss(train.sent, int(train.value))

    def _miss(self, pulses: int, position: int) -> None:
        self._missed += max(pulses, 0)
        self.surplus += max(-pulses, 0)
        self._missed_position += position

    def _close(self, end_ns: int, now_ns: int) -> None:
        """End the present segment at an instant, and add up those that are over."""
        for segment in self._segments:
            segment.until_ns = min(segment.until_ns, end_ns)
        while self._segments and (self._segments[0].until_ns <= now_ns or len(self._segments) >= _MOST_OPEN):
            segment = self._segments.pop(0)
            if segment.waveform.start_ns <= segment.until_ns:
                self._level = segment.waveform.level_at(segment.until_ns)
            pulses = segment.pulses_at(segment.until_ns)
            self._received += pulses
            self._position += segment.direction * pulses
            self._miss(segment.early, segment.direction * segment.early)
