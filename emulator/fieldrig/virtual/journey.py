"""A served rig and its past: the present, checkpoints of it, and what was asked of it.

The rig is in a keeper (`keeper.py`), so that it can be branched while this process has threads and sockets.  To go back
is to make a branch of the past the present; what came after that instant has never been.
"""

import asyncio
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, Final, NamedTuple, TypeVar, cast

from fieldrig.clock import MS, NEVER_NS, S
from fieldrig.device import Value
from fieldrig.errors import ControlError, RigError
from fieldrig.outside.untrusted import shown
from fieldrig.virtual.branch_process import Asked
from fieldrig.virtual.checkpoints import Checkpoints
from fieldrig.virtual.keeper import KeptRig
from fieldrig.virtual.readings import seconds
from fieldrig.virtual.served import Played, ServedRig

T = TypeVar("T")

PERIOD_NS: Final = 5 * S
SPACING_S: Final = 0.25
"""Least time between two checkpoints, in real time: at full speed, one in each period of the rig took most of its time.
The way back repeats what the rig did in this time, as fast as it did it.
"""
KEEP: Final = 64
"""Checkpoints that are kept: 0.3 GB for a rig of some devices."""
WINDOWS_NS: Final = (10 * MS, 500 * MS)
"""How far back a search looks first.  After that it goes from checkpoint to checkpoint."""


LOADING_NS: Final = MS // 10
"""How exactly the instant is known at which a device got the program that is searched: less than a cycle of any."""


class Search(NamedTuple):
    """A question about the past to one device: when did something happen last?

    The device is given `begin` in the past.  Its answer to `look` at the end has the `number` of what it has found, 0
    for nothing, and `at_ns`.  To go there, it is given `begin` with that number as `stop_at`, and it stops by itself;
    then its answer to `look` has `is_there`.
    """

    device: str
    question: str
    begin: Mapping[str, Any]
    look: Mapping[str, Any]


class Journey:
    """The present of a served rig, and the way back."""

    def __init__(self, rig: KeptRig | ServedRig, why_not: str = "") -> None:
        """`why_not` says why it cannot go back."""
        self.rig = rig
        self.backs = 0
        """How often it has gone back."""
        self.back_ns = 0
        """The instant to which it went back last."""
        self._why_not = why_not
        self._checkpoints: Checkpoints | None = None
        self._due_ns, self._taken_s = NEVER_NS, 0.0
        if not why_not:
            checkpoints = self._checkpoints = Checkpoints(rig, PERIOD_NS, KEEP)
            self._due_ns = checkpoints.due_ns(rig.now_ns)

    @property
    def now_ns(self) -> int:
        return self.rig.now_ns

    @property
    def first_ns(self) -> int | None:
        """The first instant to which the rig can go back; None if it cannot."""
        return None if self._checkpoints is None else self._checkpoints.first_ns

    def play(self, until_ns: int | None, for_s: float) -> Played:
        """Run a slice, as `ServedRig.play` does, and take the checkpoint that is due."""
        checkpoints = self._checkpoints
        if checkpoints is None:
            return self.rig.play(until_ns, for_s)
        checkpoints.has_run = True
        if time.monotonic() - self._taken_s < SPACING_S:
            return self.rig.play(until_ns, for_s)
        self._due_ns = max(self._due_ns, checkpoints.due_ns(self.now_ns))
        if until_ns is not None and until_ns < self._due_ns:
            return self.rig.play(until_ns, for_s)
        played = self.rig.play(self._due_ns, for_s)
        if played.is_reached:
            self._park(checkpoints, until_ns, played.next_ns)
        return played._replace(is_reached=until_ns is not None and self.now_ns >= until_ns)

    def set(self, device: str, key: str, value: Value) -> None:
        self._noted("set", device, key, value)
        self.rig.set(device, key, value)

    def answer(self, device: str, question: str, message: Any) -> Any:
        self._noted("answer", device, question, message)
        return self.rig.answer(device, question, message)

    def add_fault(self, where: str, fault: Mapping[str, Any]) -> int:
        self._noted("add_fault", where, fault)
        return self.rig.add_fault(where, fault)

    def clear_fault(self, where: str, number: int) -> None:
        self._noted("clear_fault", where, number)
        self.rig.clear_fault(where, number)

    def restart(self, device: str) -> None:
        self._noted("restart", device)
        self.rig.restart(device)

    def call(self, function: Callable[..., T], *arguments: Any) -> T:
        """Return what `function(rig, ...)` returns; it changes the rig, and does not let it run."""
        self._noted("call", function, *arguments)
        return self.rig.call(function, *arguments)

    def back(self, ns: int) -> None:
        """Make the rig as it was when its clock came to `ns` the present.  ControlError if that is not possible."""
        checkpoints = self._way_back()
        if ns > self.now_ns:
            raise ControlError(
                f"the rig cannot go back to {seconds(ns)}: it is at {seconds(self.now_ns)}", "`fieldrig step` goes on"
            )
        if ns < checkpoints.first_ns:
            raise ControlError(
                f"the rig cannot go back to {seconds(ns)}",
                f"the first instant that it remembers is {seconds(checkpoints.first_ns)}",
            )
        before = checkpoints.asked_before(ns)
        self._become(checkpoints, _past(checkpoints, ns), before)

    async def find(self, search: Search, before_ns: int | None = None) -> Mapping[str, Any]:
        """Return the device's answer about the last time before an instant, or now; its number is 0 for none."""
        found, start = await self._found(self._way_back(), search, self._end_ns(before_ns))
        if start is not None:
            start.rig.close()
        return found

    async def go_to(self, search: Search, before_ns: int | None = None) -> Mapping[str, Any]:
        """Do the same, and make that instant the present."""
        checkpoints = self._way_back()
        found, start = await self._found(checkpoints, search, self._end_ns(before_ns))
        if start is None:
            return found
        with start.rig as rig:
            past = rig.branch()
        begin = Asked(
            past.now_ns, True, "answer", (search.device, search.question, {**search.begin, "stop_at": found["number"]})
        )
        try:
            past.answer(*begin.arguments)
            is_there = partial(_is_there, search.device, search.question, dict(search.look))
            count = past.call(ServedRig.repeat_until_there, start.asked, int(found["at_ns"]), is_there)
        except BaseException:
            past.close()
            raise
        self._become(checkpoints, past, start.before, [begin, *start.asked[:count]])
        return found

    def close(self) -> None:
        """End the rig and its past."""
        if self._checkpoints is not None:
            self._checkpoints.close()
        self.rig.close()

    async def _found(
        self, checkpoints: Checkpoints, search: Search, end_ns: int
    ) -> "tuple[Mapping[str, Any], _Start | None]":
        """Look for it piece by piece, the last one first; return the answer, and where its piece begins."""
        found: Mapping[str, Any] = {"number": 0}
        asked_ns, is_first = end_ns + 1, True
        for piece_ns in self._starts(checkpoints, end_ns):
            start_ns = piece_ns if is_first else _begins(checkpoints, search, piece_ns, end_ns)
            if start_ns is not None:
                before = checkpoints.asked_before(start_ns)
                start = _Start(_past(checkpoints, start_ns), before, checkpoints.asked(before, asked_ns))
                try:
                    found = _looked(search, start, end_ns)
                except BaseException:
                    start.rig.close()
                    raise
                if found["number"]:
                    return found, start
                start.rig.close()
            end_ns, asked_ns, is_first = piece_ns, piece_ns, False
            await asyncio.sleep(0)  # others may ask something
        return found, None

    def _starts(self, checkpoints: Checkpoints, end_ns: int) -> Iterator[int]:
        """Yield where the pieces of the past begin, the last one first."""
        last_ns = end_ns + 1
        for ns in (*(end_ns - window_ns for window_ns in WINDOWS_NS), *reversed(checkpoints.instants())):
            if checkpoints.first_ns <= ns < last_ns:
                yield ns
                last_ns = ns

    def _end_ns(self, before_ns: int | None) -> int:
        return self.now_ns if before_ns is None else min(before_ns, self.now_ns)

    def _become(self, checkpoints: Checkpoints, past: KeptRig, before: int, since: Sequence[Asked] = ()) -> None:
        present, self.rig = self.rig, past
        present.close()
        checkpoints.go_on_with(past, before, since)
        self._due_ns = checkpoints.due_ns(past.now_ns)
        self.backs, self.back_ns = self.backs + 1, past.now_ns

    def _way_back(self) -> Checkpoints:
        if self._checkpoints is None:
            raise ControlError(self._why_not, "start it on Linux with `processes: one`")
        return self._checkpoints

    def _noted(self, call: str, *arguments: Any) -> None:
        if self._checkpoints is not None:
            self._checkpoints.note(call, *arguments)

    def _park(self, checkpoints: Checkpoints, until_ns: int | None, next_ns: int | None) -> None:
        """Take a checkpoint; the next one is due before the rig does something, if it sleeps over several."""
        checkpoints.take()
        self._taken_s = time.monotonic()
        self._due_ns = checkpoints.due_ns(self.now_ns)
        if next_ns is not None and until_ns is None:
            self._due_ns = max(self._due_ns, next_ns // PERIOD_NS * PERIOD_NS)


class _Start(NamedTuple):
    """The beginning of a piece of the past."""

    rig: KeptRig
    before: int
    """How much was asked before it."""
    asked: Sequence[Asked]
    """The calls from outside in it."""


def _past(checkpoints: Checkpoints, ns: int) -> KeptRig:
    """Return a branch of the past, which is a rig like the present."""
    return cast(KeptRig, checkpoints.back(ns))


def _looked(search: Search, start: "_Start", end_ns: int) -> Mapping[str, Any]:
    """Return what the device finds in a piece of the past."""
    with start.rig.branch() as past:
        past.answer(search.device, search.question, search.begin)
        past._repeat(start.asked, end_ns)
        return _checked(search, past.answer(search.device, search.question, search.look))


def _begins(checkpoints: Checkpoints, search: Search, first_ns: int, end_ns: int) -> int | None:
    """Return the instant in a piece of the past from which the device can search; None if it cannot in all of it.

    It refuses while it has no program yet, or an older one without what is looked for.
    """
    refused_ns = first_ns
    ns: int
    for ns in (first_ns, *range(first_ns + WINDOWS_NS[1], end_ns, WINDOWS_NS[1]), end_ns):
        if _may_begin(checkpoints, search, ns):
            while ns - refused_ns > LOADING_NS:
                middle_ns = (ns + refused_ns) // 2
                if _may_begin(checkpoints, search, middle_ns):
                    ns = middle_ns
                else:
                    refused_ns = middle_ns
            return ns
        refused_ns = ns
    return None


def _may_begin(checkpoints: Checkpoints, search: Search, ns: int) -> bool:
    with _past(checkpoints, ns) as past:
        try:
            past.answer(search.device, search.question, search.begin)
        except RigError:
            return False
    return True


def _checked(search: Search, answer: Any) -> Mapping[str, Any]:
    """Return the answer of a device to a search.  ControlError for another question of an outsider."""
    match answer:
        case {"number": int(), "at_ns": int(), "is_there": bool()}:
            return dict(answer)
    raise ControlError(f"{search.device} does not search its past by {shown(search.question)}", "expected `debug`")


def _is_there(device: str, question: str, look: Mapping[str, Any], rig: ServedRig) -> bool:
    answer = rig.answer(device, question, look)
    return isinstance(answer, Mapping) and bool(answer.get("is_there"))
