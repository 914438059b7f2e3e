"""The nominal run of a rig with branches on the way, so that nothing is played twice that comes before an action."""

from typing import TYPE_CHECKING, Final

from fieldrig_devices.search import run

if TYPE_CHECKING:
    from fieldrig.virtual.branch import Branch

MARKS: Final = 16
"""Branches along the nominal run, made when they are needed first."""


class Trunk:
    """Branches at the begin, at marks on the way, and at the instant that was asked for last."""

    def __init__(self, root: "Branch", length_ns: int) -> None:
        """`root` is at the begin of the scenario."""
        self._grid_ns = max(1, length_ns // MARKS)
        self._marks = [root]
        self._last, self._last_ns = root, 0
        self.cpu_s = 0.0
        """The processor time of the nominal run so far, in seconds."""

    def before(self, ns: int) -> "Branch":
        """Return a branch at a mark that is not after an instant of the scenario."""
        number = min(ns // self._grid_ns, MARKS - 1)
        while len(self._marks) <= number:
            self._marks.append(self._gone_on(self._marks[-1].branch(), len(self._marks) * self._grid_ns))
        return self._marks[number]

    def at(self, ns: int) -> "Branch":
        """Return a branch at an instant of the scenario; the next call of `at` may take it further."""
        mark = self.before(ns)
        mark_ns = self._marks.index(mark) * self._grid_ns
        if mark_ns == ns:
            return mark
        if not mark_ns < self._last_ns <= ns:
            if self._last_ns:
                self._last.close()
            self._last = mark.branch()
        if self._last_ns != ns:
            self._gone_on(self._last, ns)
            self._last_ns = ns
        return self._last

    def begin_again(self) -> None:
        """Let all branches but the root go, of which one was ended from outside."""
        root, *others = self._marks
        if self._last is not root:
            others.append(self._last)
        for branch in others:
            branch.close()
        self._marks, self._last, self._last_ns = [root], root, 0

    def _gone_on(self, branch: "Branch", ns: int) -> "Branch":
        self.cpu_s += branch.call(run.advance, ns)
        return branch
