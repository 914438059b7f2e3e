"""Plays a schedule to a rig in virtual time, and judges it: here, in a branch, or in a worker of a search."""

from bisect import insort
from collections.abc import Callable, Iterable, Sequence
from contextlib import AbstractContextManager, ExitStack
from enum import IntEnum
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.points.names import split_point
from fieldrig.virtual.stuck import never_stuck
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.followed import Followed
from fieldrig_devices.scenarios.guard import NOTHING_RAISES, raised_by
from fieldrig_devices.scenarios.hands import Hands
from fieldrig_devices.scenarios.places import has_power
from fieldrig_devices.scenarios.property import Property, Violation
from fieldrig_devices.scenarios.watching import Played, Track, Watching

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

__all__ = ["NOTHING_RAISES", "Played", "Stage", "Track", "play"]

LOOK_NS: Final = 1 * MS
"""The longest time between two looks: values such as the level of a tank change without an event."""


class Rank(IntEnum):
    """The order of actions at one instant, which does not depend on when each of them was planned."""

    END = 0
    """The end of a `press`."""
    MILESTONE = 1
    STEP = 2


class Due(NamedTuple):
    at_ns: int
    rank: Rank
    act: Act


def play(
    rig: "Rig",
    schedule: Schedule,
    properties: Sequence[Property],
    length_ns: int,
    *,
    recovery: Schedule = (),
    stops_early: bool = False,
    forgives: bool = False,
) -> Played:
    """Play a schedule from the present instant on.  RigError for a place or a fault that the rig does not have.

    With `stops_early` it ends at the first instant at which a property does not hold; with `forgives` a value that a
    device refuses is no error.
    """
    with Stage(rig, schedule, properties, recovery=recovery, stops_early=stops_early, forgives=forgives) as stage:
        return stage.finish(length_ns)


class Stage(ExitStack):
    """A rig with what is still to happen, and its judge.  A branch of the rig has a copy of it, which goes on alone."""

    def __init__(
        self,
        rig: "Rig",
        schedule: Schedule,
        properties: Sequence[Property],
        *,
        recovery: Schedule = (),
        stops_early: bool = False,
        is_hashed: bool = True,
        forgives: bool = False,
    ) -> None:
        """Begin at the present instant of the rig.  RigError for a place that it does not have.

        `recovery` is what the operator does in the end, when no fault is left; its instants count from there.
        Without `is_hashed` the outcome has no hash, which a tenth of the time of a run is for.  `forgives` is the
        begin of the attribute.
        """
        super().__init__()
        self._rig, self._begin_ns = rig, rig.now_ns
        self._stops_early, self._recovery, self._operator = stops_early, recovery, recovery
        self._longest_ns = max((one.within_ns or 0 for one in properties), default=0)
        self._due: list[Due] = []
        """The actions that have not been done, in the order of time."""
        self._places = Followed(rig, self._on_change, self.callback)
        self._seen = Watching(properties, self._places.add_all(place for one in properties for place in one.places))
        self._hands = Hands(rig, self._read, self._write, self._places.send, partial(has_power, rig))
        self._healed = False
        self._looked_ns = -1
        """The instant of the last look: between two events of the rig nothing is different at the same instant."""
        self.forgives = forgives
        """True if a value that a device refuses is not an error, but a consequence of what has happened: after a fault
        or a restart, when a program is not there yet, and in a search."""
        for name in _written(recovery):
            self.follow(name)
        self.add(*schedule)
        self.callback(rig.on_instant(self._on_instant))
        self._hash = rig.trace_hash if is_hashed else str
        self._hash()
        self._hash_then = ""

    def follow(self, name: str) -> None:
        """Keep the changes of a place from now on.  RigError if the rig does not have it."""
        self._follow(name, is_read=False)

    @property
    def now_ns(self) -> int:
        """The instant from the begin."""
        return self._rig.now_ns - self._begin_ns

    @property
    def violations(self) -> tuple[Violation, ...]:
        """The violations so far."""
        return self._seen.violations

    def track(self, place: str) -> Track:
        """Return the changes of a place that is followed, so far."""
        return self._seen.track(place)

    @property
    def is_over(self) -> bool:
        """True if it ends at the first violation, and there has been one; a rig in which a device raised ends too."""
        return self._seen.has_raised or (self._stops_early and bool(self._seen.violations))

    def add(self, *acts: Act) -> None:
        """Let more happen.  RigError for a place that the rig does not have."""
        for name in _written(acts):
            if has_power(self._rig, split_point(name)[0]):
                self.follow(name)
        for act in acts:
            if act.when:
                self._await(act)
            else:
                self._plan(act, Rank.STEP)
        if self._healed and acts:
            self._healed = False
            self._seen.hurt()
        self._seen.milestones.look(self.now_ns, self._seen.values)

    def run_until(self, until_ns: int) -> None:
        """Let everything happen up to an instant, where what is done at that instant has not happened yet."""
        with self._never_stuck():
            while not self.is_over:
                self._guarded(self._do_due)
                if self.now_ns >= until_ns:
                    return
                self._guarded(partial(self._run, min(self._due[0].at_ns, until_ns) if self._due else until_ns))

    def finish(self, length_ns: int) -> Played:
        """Play to the end and until the machine has had its time to come back, and judge what had to happen."""
        with self._never_stuck():
            self.run_until(length_ns)
            if not self.is_over:
                self._guarded(self._do_due)
                self._come_back()
        if not self.is_over:
            self._seen.end(self.now_ns)
            self._note_hash()
        left = () if self.is_over else (*self._seen.milestones.waiting, *(one.act for one in self._due))
        outcome = self._seen.outcome(self.now_ns, self._hash())
        return outcome._replace(unreached=left, hash_then=self._hash_then)

    def _come_back(self) -> None:
        """Go on to the end of all faults that have one, let the operator do the rest, and wait for what has to come."""
        while self._hands.faults_end() and not self.is_over:
            self.run_until(self.now_ns + LOOK_NS)
        recovery, self._recovery = self._recovery, ()
        if self._due or self._hands.has_faults():
            return
        begin_ns = self.now_ns
        self.add(*(act if act.when else act._replace(at_ns=begin_ns + act.at_ns) for act in recovery))
        while not self.is_over and (self._due or self._waits_ns(begin_ns) > self.now_ns):
            self.run_until(self._due[-1].at_ns if self._due else self.now_ns + LOOK_NS)
            self._guarded(self._do_due)
            self._heal()

    def _waits_ns(self, begin_ns: int) -> int:
        """Return until when something is waited for: that the machine comes back, or a milestone of the operator."""
        waits = any(act in self._operator for act in self._seen.milestones.waiting)
        return begin_ns + self._longest_ns if waits else self._seen.recovery_ns or 0

    def _never_stuck(self) -> AbstractContextManager[None]:
        """End a device that computes without end."""
        return never_stuck(lambda: self._rig.now_ns)

    def _guarded(self, step: Callable[[], None]) -> None:
        """Do a step; what a device raises there is a violation, and the end.  RigError for what a user can fix."""
        raised = raised_by(step)
        if raised is not None:
            self._seen.raised(Violation(raised.property, self.now_ns, raised.what, ()))
        self._note_hash()

    def _note_hash(self) -> None:
        """Note the hash at the first violation, at which a search ends."""
        if not self._hash_then and self._seen.is_violated:
            self._hash_then = self._hash()

    def _await(self, act: Act) -> None:
        for name in expression_of(act.when).places:
            self._follow(name, is_read=True)
        self._seen.await_milestone(act)

    def _run(self, until_ns: int) -> None:
        """Run from instant to instant, until something is to be done."""
        end_ns = self._begin_ns + until_ns
        while self._rig.now_ns < end_ns and not self.is_over:
            look_ns = min(end_ns, self._begin_ns + (self.now_ns // LOOK_NS + 1) * LOOK_NS)
            # With a call of on_instant the rig asks after each instant whether it has to stop, of which there are many.
            if self._rig.run_until(look_ns, self._has_to_stop) and self._looked_ns != self._rig.now_ns:
                self._on_instant()
            if self._takes_reached():
                return
            self._heal()

    def _has_to_stop(self) -> bool:
        return self.is_over or self._seen.milestones.has_reached

    # ---- what happens

    def _takes_reached(self) -> bool:
        """Take the actions whose milestones have been reached, and return whether there are any."""
        reached = list(self._seen.milestones.reached())
        for act in reached:
            self._plan(act, Rank.MILESTONE)
        return bool(reached)

    def _plan(self, act: Act, rank: Rank) -> None:
        insort(self._due, Due(act.at_ns, rank, act), key=_instant)

    def _do_due(self) -> None:
        self._takes_reached()
        while self._due and self._due[0].at_ns <= self.now_ns:
            act = self._due.pop(0).act
            self._seen.done.append(act._replace(at_ns=self.now_ns))
            after = self._done(act)
            if after is not None:
                self._plan(after, Rank.END)
            self._takes_reached()

    def _done(self, act: Act) -> Act | None:
        """Do an action, and return the one that ends it.  RigError if the rig refuses it, unless it is forgiven."""
        try:
            return self._hands.do(act)
        except ControlError:
            if act.verb not in ("set", "press") or not self.forgives:
                raise
            return None
        finally:
            self.forgives = self.forgives or act.verb in ("fault", "restart")

    def _read(self, name: str) -> Value:
        self.follow(name)
        return self._places.read(name)

    def _write(self, name: str, value: Value) -> None:
        self.follow(name)
        self._places.write(name, value)

    def _heal(self) -> None:
        """Note the instant from which on nothing is to be done, and there is no fault any more."""
        is_waiting = self._healed or self._due or self._recovery or self._seen.milestones.waiting
        if not is_waiting and not self._hands.has_faults():
            self._healed = True
            self._seen.heal(self.now_ns)
            self._note_hash()

    # ---- what is seen

    def _follow(self, name: str, *, is_read: bool) -> None:
        value = self._places.add(name, is_read=is_read)
        if value is not None:
            self._seen.follow(self.now_ns, name, value)

    def _on_change(self, name: str, value: Value) -> None:
        self._seen.change(self.now_ns, name, value)

    def _on_instant(self) -> None:
        """Look at the present values; a place of a device without power keeps its last one."""
        self._looked_ns = self._rig.now_ns
        self._seen.look(self.now_ns, self._places.read_all())
        self._note_hash()


def _instant(due: Due) -> tuple[int, Rank]:
    return due.at_ns, due.rank


def _written(acts: Iterable[Act]) -> list[str]:
    return [act.where for act in acts if act.verb in ("set", "press")]
