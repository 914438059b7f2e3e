"""Messages that buses publish wait in a limited queue, and none is lost without being counted."""

import logging
from typing import Any

import pytest

from fieldrig.real import bus_inbox
from fieldrig.real.bus_inbox import Batch, Waiting


def batch(first: int, count: int, bus: str = "can0", process: str = "can0") -> Batch:
    entries: list[Any] = [[number, "io", "00"] for number in range(first, first + count)]
    return Batch(bus, {"family": "can", "process": process, "first": first, "epoch_ns": 0, "entries": entries})


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> Waiting:
    monkeypatch.setattr(bus_inbox, "MOST_MESSAGES", 10)
    monkeypatch.setattr(bus_inbox, "MOST_BATCHES", 4)
    return Waiting()


def test_what_is_over_the_limit_is_dropped_counted_and_logged(few: Waiting, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        for first in (0, 4, 8):
            few.put(batch(first, 4))
    assert [one.content["first"] for one in few.take()] == [0, 4]
    assert few.missed("can0") == 4
    assert few.reached.figures() == {"batches over the limit": 1.0}
    assert "8 messages wait to be read; those of a batch are lost" in caplog.text


def test_what_was_dropped_is_not_counted_again_as_a_gap(few: Waiting) -> None:
    for first in (0, 4, 8):
        few.put(batch(first, 4))
    assert len(list(few.take())) == 2
    few.put(batch(12, 1))
    assert [one.content["first"] for one in few.take()] == [12]
    assert few.missed("can0") == 4


def test_batches_without_messages_are_limited_too(few: Waiting) -> None:
    for _ in range(6):
        few.put(batch(0, 0))
    assert len(list(few.take())) == 4
    assert few.reached.figures() == {"batches over the limit": 2.0}


def test_a_gap_in_the_numbers_of_a_publisher_is_what_was_lost_on_the_way(few: Waiting) -> None:
    few.put(batch(100, 1))  # it had listeners before
    few.put(batch(103, 1))
    few.put(batch(7, 1, process="other"))
    few.put(batch(0, 1))  # it has begun again
    assert len(list(few.take())) == 4
    few.put(batch(2, 1, bus="can1"))
    few.put(batch(9, 1, bus="can1"))
    assert (few.missed("can0"), few.missed("can1")) == (2, 6)


def test_there_is_no_end_of_names_of_publishers(few: Waiting, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bus_inbox, "MOST_SOURCES", 2)
    for number in range(5):
        few.put(batch(0, 0, process=f"p{number}"))
    assert len(few._expected) == 2
