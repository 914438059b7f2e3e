"""Notices for `up` and `watch`: faults of buses and devices that begin and end, and conditions.

A condition is a state that a person at a machine would see at once, such as an open ring or an emergency stop
(`BusModel.conditions`).  Each process looks at its parts every `PERIOD_S`, and before and after a fault is added or
cleared, and publishes only changes.  A fault that has come and gone between two looks is reported as one that is over.
"""

import asyncio
from collections.abc import Callable, Iterator, Mapping, Sequence
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.control.fault_questions import in_words as fault_in_words
from fieldrig.control.messages import Control

PERIOD_S: Final = 0.5
CHANGES: Final = ("add_fault", "clear_fault")
"""Questions that make a fault begin or end at once."""
FAULT: Final = "fault "
"""Begins the keys of faults; their numbers follow."""


class Notice(NamedTuple):
    """A change of one part of a rig."""

    part: str
    key: str
    """The name of the fault or condition in this part."""
    text: str
    is_over: bool


Faults = Callable[[], Mapping[int, Mapping[str, Any]]]
Conditions = Callable[[], Mapping[str, str]]


class Watched:
    """One part of a rig, with what has been reported of it."""

    def __init__(self, part: str, faults: Faults, conditions: Conditions | None = None) -> None:
        self._part, self._faults, self._conditions = part, faults, conditions
        self._told: dict[str, str] = {}
        """The texts of what is present, by key."""
        self._ends: dict[str, tuple[int, int]] = {}
        """The instants between which each fault with a limited time ends by itself, as of the last look."""
        self._seen: set[int] = set()
        """Numbers of the faults that have been reported, so that one that is over is not reported again."""

    def look(self, now_ns: Callable[[], int] = lambda: 0) -> list[tuple[Notice, tuple[int, int] | None]]:
        """Return what has changed since the last look, each with the instants between which it was, if known."""
        ends, before_ns = self._ends, now_ns()
        faults = self._faults()
        self._ends = dict(_ends_of(faults, before_ns, now_ns()))
        return [(notice, ends.get(notice.key) if notice.is_over else None) for notice in self._changes(faults)]

    def _changes(self, faults: Mapping[int, Mapping[str, Any]]) -> list[Notice]:
        present, passed = dict[str, str](), dict[str, str]()
        for number, fault in faults.items():
            if fault["state"] == "on":
                present[f"{FAULT}{number}"] = fault_in_words(fault)
            elif fault["state"] == "over" and number not in self._seen:
                passed[f"{FAULT}{number}"] = fault_in_words(fault)
        self._seen = {number for number, fault in faults.items() if fault["state"] != "waiting"}
        if self._conditions is not None:
            present |= self._conditions()
        begun = {key: text for key, text in {**present, **passed}.items() if key not in self._told}
        ended = {key: text for key, text in {**self._told, **passed}.items() if key not in present}
        self._told = present
        return [
            *(Notice(self._part, key, text, is_over=False) for key, text in begun.items()),
            *(Notice(self._part, key, text, is_over=True) for key, text in ended.items()),
        ]


async def look_on(
    control: Control,
    watched: Sequence[Watched],
    now_ns: Callable[[], int],
    also: Callable[[], object] = lambda: None,
) -> None:
    """Publish what changes, until cancelled; `also` is called as often.

    A notice has the instants between which it happened: `after_ns` of the look before and `at_ns` of this one, or less
    for a fault whose time was limited.
    """
    last_ns = now_ns()

    def look() -> None:
        nonlocal last_ns
        after_ns, last_ns = last_ns, now_ns()
        for part in watched:
            for notice, ended in part.look(now_ns):
                is_within = ended is not None and after_ns < ended[1] <= last_ns  # else it was cleared before
                first, last = ended if ended is not None and is_within else (after_ns, last_ns)
                control.publish(f"notice/{notice.part}", notice._asdict() | {"after_ns": first, "at_ns": last})

    control.around(CHANGES, look)
    while True:
        also()
        look()
        await asyncio.sleep(PERIOD_S)


def _ends_of(
    faults: Mapping[int, Mapping[str, Any]], before_ns: int, after_ns: int
) -> Iterator[tuple[str, tuple[int, int]]]:
    """Yield when each fault with a limited time will be over; `left_ms` is rounded up to whole milliseconds."""
    for number, fault in faults.items():
        left_ms = fault.get("left_ms")
        if isinstance(left_ms, int):
            yield f"{FAULT}{number}", (before_ns + (left_ms - 1) * MS, after_ns + left_ms * MS)


def in_words(notice: Notice) -> str:
    """Return `fault 1: drop count=3` or `emergency stop`, and later `fault 1: over` or `emergency stop: over`."""
    is_fault = notice.key.startswith(FAULT)
    if notice.is_over:
        return f"{notice.key if is_fault else notice.text}: over"
    return f"{notice.key}: {notice.text}" if is_fault else notice.text


def span_of(message: Any) -> tuple[int, int] | None:
    """Return the instants between which a notice happened, on the clock of the rig; None if it does not say."""
    match message:
        case {"after_ns": int(after_ns), "at_ns": int(at_ns)}:
            return after_ns, at_ns
    return None


def taken(message: Any) -> Notice | None:
    """Return a notice that was published by a process; None for anything else."""
    match message:
        case {"part": str(part), "key": str(key), "text": str(text), "is_over": bool(is_over)}:
            return Notice(part, key, text, is_over)
    return None
