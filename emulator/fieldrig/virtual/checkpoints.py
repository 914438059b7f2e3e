"""The checkpoints of a rig: branches of past instants, and what was asked of the rig between them.

To go back is to branch the last checkpoint before, and to repeat what was asked since.  A rig that is given the same at
the same instants does the same, so the branch is the rig as it was, to the last bit.
"""

from bisect import bisect_left
from collections.abc import Mapping, Sequence
from copy import deepcopy
from typing import Any, Final, NamedTuple

from fieldrig.errors import RigError
from fieldrig.system.this_process import own_bytes
from fieldrig.virtual.branch import Branch, Parking
from fieldrig.virtual.branch_process import Asked
from fieldrig.virtual.readings import seconds

MOST_ASKED: Final = 100_000
"""Calls that are kept; for one more, the first checkpoint is forgotten with those after it."""


class Checkpoint(NamedTuple):
    branch: Branch
    asked: int
    """The number of calls from outside before it."""
    is_fixed: bool
    """True if it stays: something that no branch can repeat came right before it."""


class Checkpoints:
    def __init__(self, rig: Parking, period_ns: int, keep: int) -> None:
        self.period_ns, self.keep = period_ns, keep
        self.has_run = False
        self._rig = rig
        self._asked: list[Asked] = []
        self._kept: list[Checkpoint] = []
        self.take(is_fixed=True)

    def due_ns(self, after_ns: int) -> int:
        """Return the first multiple of the period after an instant."""
        return (after_ns // self.period_ns + 1) * self.period_ns

    def take(self, is_fixed: bool = False) -> None:
        new, last = Checkpoint(self._rig._parked(), len(self._asked), is_fixed), self._kept[-1:]
        if last and (last[0].branch.now_ns, last[0].asked) == (new.branch.now_ns, new.asked):
            self._kept.pop().branch.close()  # no way leads back to it any more
            new = new._replace(is_fixed=is_fixed or last[0].is_fixed)
        self._kept.append(new)
        if len(self._kept) > self.keep:
            self._thin()

    def note(self, call: str, *arguments: Any) -> None:
        """Keep a call from outside; it has not been made yet."""
        if len(self._asked) >= MOST_ASKED:
            self._forget_the_first()
        self._asked.append(Asked(self._rig.now_ns, self.has_run, call, deepcopy(arguments)))
        self.has_run = False

    @property
    def first_ns(self) -> int:
        """The first instant to which the rig can go back."""
        return self._kept[0].branch.now_ns

    def back(self, ns: int) -> Branch:
        """Return a branch of the rig as it was when its clock came to `ns`."""
        before = self.asked_before(ns)
        found = [one for one in self._kept if one.branch.now_ns <= ns and one.asked <= before]
        if not found:
            raise RigError(
                f"the rig cannot go back to {seconds(ns)}",
                f"its first checkpoint is at {seconds(self.first_ns)}",
            )
        branch = found[-1].branch.branch()
        try:
            branch._repeat(self._asked[found[-1].asked : before], ns)
        except BaseException:
            branch.close()
            raise
        return branch

    def asked_before(self, ns: int) -> int:
        """Return how much was asked before an instant."""
        return bisect_left(self._asked, ns, key=lambda asked: asked.at_ns)

    def asked(self, first: int, before_ns: int) -> Sequence[Asked]:
        """Return what was asked before an instant, without the `first` of all."""
        return self._asked[first : self.asked_before(before_ns)]

    def instants(self) -> Sequence[int]:
        """Return the instants of the checkpoints."""
        return [one.branch.now_ns for one in self._kept]

    def go_on_with(self, rig: Parking, before: int, since: Sequence[Asked] = ()) -> None:
        """Have another past: the first `before` of what was asked, and `since` after that.  `rig` is the present."""
        self._rig, self.has_run = rig, True
        self._asked[before:] = since
        last_ns = since[0].at_ns if since else rig.now_ns
        while self._kept[-1].asked > before or self._kept[-1].branch.now_ns > last_ns:
            self._kept.pop().branch.close()

    def memory(self) -> Mapping[int, int]:
        """Return the bytes that each checkpoint has for itself, by its instant."""
        return {one.branch.now_ns: own_bytes(one.branch.pid) or 0 for one in self._kept}

    def close(self) -> None:
        while self._kept:
            self._kept.pop().branch.close()

    def _forget_the_first(self) -> None:
        """Forget the first checkpoint, with what was asked until the next one."""
        if len(self._kept) == 1:
            self.take(is_fixed=True)
        self._kept.pop(0).branch.close()
        count = self._kept[0].asked
        del self._asked[:count]
        self._kept = [one._replace(asked=one.asked - count) for one in self._kept]

    def _thin(self) -> None:
        """Drop the checkpoint that leaves the smallest gap for its age, so that the gaps grow with the age."""
        now_ns = self._rig.now_ns
        gaps = [
            ((after.branch.now_ns - before.branch.now_ns) / (now_ns - one.branch.now_ns + self.period_ns), place)
            for place, (before, one, after) in enumerate(
                zip(self._kept, self._kept[1:], self._kept[2:], strict=False), 1
            )
            if not one.is_fixed
        ]
        if gaps:
            self._kept.pop(min(gaps)[1]).branch.close()
