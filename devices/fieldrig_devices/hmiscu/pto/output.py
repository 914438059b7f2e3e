"""The pulse output: turns a plan into segments of a pulse train, piece by piece, and counts the pulses.

A plan that replaces another one begins at the end of the period that is under way, because a pulse that has risen is
completed.  So no pulse is lost, and none is shorter than its frequency says.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction

from fieldrig.clock import NEVER_NS
from fieldrig_bus.signals.pulse_train import PulseTrain
from fieldrig_devices.hmiscu.pto.exact import root
from fieldrig_devices.hmiscu.pto.piece import Piece, Plan

_AS_PER_NS = 10**9

OnSegments = Callable[[Sequence[PulseTrain]], None]
"""Called with the segments that have begun since the last call, in their order; the train at rest is one of them."""


@dataclass(frozen=True, slots=True)
class Junction:
    """The end of the period that is under way: the earliest instant at which another plan can begin."""

    instant_ns: int
    square: Fraction
    """Square of the frequency in Hz at that instant; 0 if the train ends there."""


class PulseOutput:
    """One pulse output.  Times never go back."""

    def __init__(self, name: str, on_segments: OnSegments, start_ns: int = 0) -> None:
        self._on_segments = on_segments
        self.train = PulseTrain(name, 0, start_ns=start_ns, epoch_ns=start_ns)
        """The segment at the last instant of `advance`."""
        self._plan: Plan = iter(())
        self._following: Piece | None = None
        self._end_as: int | None = None
        """The end of the present piece; None at rest, and while it goes on."""

    @property
    def next_ns(self) -> int:
        """The instant at which the next piece begins or the train comes to rest; `NEVER_NS` if none is planned."""
        return NEVER_NS if self._end_as is None else -(-self._end_as // _AS_PER_NS)

    @property
    def is_moving(self) -> bool:
        return self.train.is_moving

    @property
    def is_endless(self) -> bool:
        """True on a plateau that lasts until another plan replaces it."""
        return self.train.count is None and self._end_as is None

    def begin(self, now_ns: int, plan: Plan, direction: int) -> None:
        """Begin a plan at once.  The output is at rest."""
        self.train = self.train.then(now_ns, direction=direction)
        self._take(plan, now_ns)
        self.advance(now_ns)

    def junction(self, now_ns: int) -> Junction:
        """Return where another plan can take over from the train, which is moving at `now_ns`."""
        train = self.train
        begun = train.pulses_at(now_ns)
        after_ns = train.rise_ns(begun + 1)
        if after_ns is not None:
            return Junction(after_ns, self._square(begun))
        is_last = self._following is None  # and otherwise the last period of the piece
        return Junction(self.next_ns, Fraction(0) if is_last else self._square(begun))

    def replace(self, at: Junction, plan: Plan) -> None:
        """Let a plan take over at a junction."""
        self._take(plan, at.instant_ns)

    def _take(self, plan: Plan, at_ns: int) -> None:
        self._plan, self._following, self._end_as = plan, next(plan, None), at_ns * _AS_PER_NS

    def advance(self, now_ns: int) -> None:
        """Begin every piece that is due, and report the segments."""
        begun: list[PulseTrain] = []
        while self._end_as is not None and self._end_as <= now_ns * _AS_PER_NS:
            start_ns, piece = self.next_ns, self._following
            if piece is None:
                self.train, self._end_as = self.train.then(start_ns), None
            else:
                self.train = self.train.then(start_ns, piece.frequency, piece.rate, piece.count)
                self._end_as = None if piece.count is None else self._end_as + piece.duration_as
                self._following = next(self._plan, None)
            begun.append(self.train)
        if begun:
            self._on_segments(begun)

    def sent_at(self, now_ns: int) -> int:
        """Return the pulses that have risen up to and including `now_ns`, in both directions."""
        return self.train.sent_at(now_ns)

    def frequency_at(self, now_ns: int) -> int:
        """Return the frequency of the period that is under way, to the nearest Hz; 0 at rest."""
        train = self.train
        begun = train.pulses_at(now_ns)
        if not begun:
            return 0
        if not train.rate:
            return round(train.frequency)
        return round((root(self._square(begun - 1)) + root(self._square(begun))) / 2)

    def _square(self, pulses: int) -> Fraction:
        """Return the square of the frequency after this many pulses of the segment."""
        frequency = Fraction(self.train.frequency)
        return max(frequency * frequency + 2 * Fraction(self.train.rate) * pulses, Fraction(0))
