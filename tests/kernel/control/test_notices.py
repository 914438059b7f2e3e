"""The notices of a rig while it runs."""

from typing import Any

from fieldrig.clock import MS
from fieldrig.control.notices import Notice, Watched, in_words, taken

DROP = {"what": "drop", "identifier": 0x185, "applied": 0}


class Part:
    """A bus whose faults and conditions a test sets."""

    def __init__(self) -> None:
        self.faults: dict[int, dict[str, Any]] = {}
        self.conditions: dict[str, str] = {}
        self.watched = Watched("can0", lambda: self.faults, lambda: self.conditions)

    def told(self) -> list[str]:
        return [in_words(notice) for notice, _ in self.watched.look()]


def test_a_fault_is_told_when_it_begins_and_when_it_is_over() -> None:
    part = Part()
    part.faults = {1: {**DROP, "state": "waiting"}}
    assert part.told() == []
    part.faults = {1: {**DROP, "state": "on"}}
    assert part.told() == ["fault 1: drop identifier=0x185"]
    part.faults = {1: {**DROP, "state": "on", "applied": 7}}
    assert part.told() == []
    part.faults = {1: {**DROP, "state": "over"}}
    assert part.told() == ["fault 1: over"]
    assert part.told() == []


def test_the_end_of_a_fault_with_a_limited_time_is_known_to_a_millisecond_by_what_was_left_of_it() -> None:
    part = Part()
    instants = iter((10 * MS, 12 * MS, 510 * MS, 511 * MS))
    part.faults = {1: {**DROP, "state": "on", "left_ms": 300}}
    assert [span for _, span in part.watched.look(lambda: next(instants))] == [None]
    part.faults = {1: {**DROP, "state": "over"}}
    assert [span for _, span in part.watched.look(lambda: next(instants))] == [(309 * MS, 312 * MS)]


def test_a_fault_that_is_cleared_is_over() -> None:
    part = Part()
    part.faults = {3: {**DROP, "state": "on"}}
    part.told()
    part.faults = {}
    assert part.told() == ["fault 3: over"]


def test_a_fault_between_two_looks_is_told_too() -> None:
    part = Part()
    part.faults = {1: {**DROP, "state": "over"}}
    assert part.told() == ["fault 1: drop identifier=0x185", "fault 1: over"]
    assert part.told() == []


def test_a_condition_is_told_when_it_begins_and_when_it_is_over() -> None:
    part = Part()
    part.conditions = {"ring": "the ring is open, without belt"}
    assert part.told() == ["the ring is open, without belt"]
    part.conditions = {"ring": "the ring is open, without belt, film"}
    assert part.told() == []
    part.conditions = {}
    assert part.told() == ["the ring is open, without belt, film: over"]


def test_only_notices_are_taken() -> None:
    notice = Notice("can0", "fault 1", "drop", is_over=True)
    assert taken(notice._asdict()) == notice
    others: list[Any] = [None, [], {"part": "can0"}, {**notice._asdict(), "text": 1}]
    for other in others:
        assert taken(other) is None
