"""The torque of a stepping motor: what its pulses ask for, what it has, and the instant at which that is too little.

A motor in step turns exactly with its pulses.  It needs the torque of the load, of dry friction and of its inertia, and
has at most the pull-out torque, which falls with the speed.  So within a segment of a pulse train, which has one rate,
there is one frequency at which it falls out of step.  Left out: resonances, and the swing of the rotor at each step.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import ceil, inf, tau
from typing import NamedTuple

from fieldrig.clock import S
from fieldrig_bus.signals.pulse_train import PulseTrain


@dataclass(frozen=True, slots=True)
class PullOut:
    """Speeds of the motor in turns/s, rising, each with the largest torque in N m, not rising; 0 above the last."""

    points: Sequence[tuple[float, float]]

    def speed_for(self, torque_nm: float) -> float:
        """Return the highest speed at which the motor has this torque; -1 if it never does."""
        if torque_nm > self.points[0][1]:
            return -1.0
        for (slow, strong), (fast, weak) in pairwise(self.points):
            if weak < torque_nm:
                return slow + (fast - slow) * (strong - torque_nm) / (strong - weak)
        return self.points[-1][0]


@dataclass(frozen=True, slots=True)
class Motor:
    """A motor with its load; torques in N m at the motor."""

    curve: PullOut
    pulses_per_turn: int
    inertia_kg_m2: float
    coulomb_nm: float
    highest_hz: float

    def needed_nm(self, direction: int, rate: float, load_nm: float) -> float:
        """Return the torque that a motion needs: the direction of turning, Hz/s along it, and the load's torque."""
        turning = tau / self.pulses_per_turn
        return abs(direction * load_nm + self.coulomb_nm + self.inertia_kg_m2 * rate * turning)

    def holds(self, load_nm: float, part: float) -> bool:
        """Return whether the motor holds the load at standstill, with this part of its torque."""
        return abs(load_nm) <= self.curve.points[0][1] * part + self.coulomb_nm

    def limit_hz(self, direction: int, rate: float, load_nm: float, part: float) -> float:
        """Return the highest frequency that the motor follows; -1 if it follows none."""
        needed_nm = self.needed_nm(direction, rate, load_nm)
        if part <= 0 < needed_nm:
            return -1.0
        turns_per_s = self.curve.speed_for(needed_nm / part if part > 0 else 0.0)
        return min(turns_per_s * self.pulses_per_turn, self.highest_hz)


def passes_ns(train: PulseTrain, hz: float, now_ns: int) -> int | None:
    """Return when the frequency of a train becomes higher than this, from now on; None if it does not."""
    if _hz(train, now_ns) > hz:
        return now_ns
    return _crosses_ns(train, hz, now_ns) if train.rate > 0 else None


def falls_to_ns(train: PulseTrain, hz: float, now_ns: int) -> int | None:
    """Return when the frequency of a train becomes this or lower, from now on; None if it does not."""
    if _hz(train, now_ns) <= hz:
        return now_ns
    return _crosses_ns(train, hz, now_ns) if train.rate < 0 else train.end_ns


class Followed(NamedTuple):
    """A segment that a motor turned with, and the instant at which another one replaced it or None if none did."""

    train: PulseTrain
    replaced_ns: int | None = None

    def cut(self, now_ns: int) -> "Followed":
        """Return the same, replaced at this instant unless it was over before."""
        return Followed(self.train, now_ns) if self.replaced_ns is None else self

    @property
    def end_ns(self) -> int | None:
        """The end of the last pulse, or of the part of it that the train had time for; None if it goes on."""
        ends = [end_ns for end_ns in (self.train.end_ns, self.replaced_ns) if end_ns is not None]
        return min(ends, default=None)

    def last_hz(self) -> float:
        """Return the frequency with which it ended; of a train that goes on, that of its beginning."""
        end_ns = self.end_ns
        return _hz(self.train, self.train.start_ns if end_ns is None else end_ns - 1)

    def stops_short_ns(self, start_hz: float) -> int | None:
        """Return when it has stopped too fast, if no other train follows; None if it has not.

        A next pulse before this instant would be a frequency that is lower by `start_hz` at most.
        """
        end_ns, last_hz = self.end_ns, self.last_hz()
        return end_ns + ceil(S / (last_hz - start_hz)) if end_ns is not None and last_hz > start_hz else None


def jump_hz(before: Followed | None, train: PulseTrain, now_ns: int) -> float:
    """Return how far the frequency jumps when a train begins at an instant, up or down.

    A reversal jumps by both frequencies.  The train before counts up to one period after its end, because senders
    round its end.
    """
    after_hz = _hz(train, now_ns)
    end_ns = None if before is None else before.end_ns
    if before is None or end_ns is None:
        return after_hz
    before_hz = before.last_hz()
    if before_hz and train.start_ns - (end_ns - 1) > S / before_hz + 1:
        before_hz = 0.0
    return abs(after_hz - before_hz) if train.direction == before.train.direction else after_hz + before_hz


def _hz(train: PulseTrain, now_ns: int) -> float:
    return float(train.frequency_at(max(now_ns, train.start_ns)))


def _crosses_ns(train: PulseTrain, hz: float, now_ns: int) -> int | None:
    seconds = (hz - float(train.frequency)) / float(train.rate)
    end_ns = train.end_ns
    when_ns = max(train.start_ns + ceil(seconds * S), now_ns) if seconds < inf else None
    return None if when_ns is None or (end_ns is not None and when_ns >= end_ns) else when_ns
