"""A host that is late: judged window by window, reported once with figures, and named beside what devices log."""

import logging
import os

import pytest

from fieldrig.clock import MS
from fieldrig.system.host_lateness import (
    LATE_NS,
    NOTED_NS,
    SETTLED_WINDOWS,
    LateHost,
    Lateness,
    LateRecords,
    Statistics,
)


class Bench:
    """A process that is made late, with a ring whose counters the test sets."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setattr(os, "getloadavg", lambda: (30.2, 0.0, 0.0))
        monkeypatch.setattr("fieldrig.system.host_lateness.usable_cores", lambda: 2)
        self.lateness = Lateness()
        self.ring = {"cycles": 0.0, "late_cycles": 0.0}
        self.host = LateHost(self.lateness, self._statistics)
        self.host.turn()

    def _statistics(self) -> dict[str, Statistics]:
        return {"ring": dict(self.ring), "can0": {"frames": 1.0}}

    def window(self, late_ns: int = 0, cycles: int = 1000, late_cycles: int = 0) -> str | None:
        self.lateness.note(late_ns)
        self.ring["cycles"] += cycles
        self.ring["late_cycles"] += late_cycles
        return self.host.turn()


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    return Bench(monkeypatch)


def test_a_host_that_is_on_time_is_not_told_of(bench: Bench) -> None:
    assert [bench.window(LATE_NS - 1, late_cycles=50) for _ in range(3)] == [None, None, None]
    assert (bench.host.words, bench.host.facts()["worst_ms"]) == ("", 50.0)


def test_late_timers_are_told_once_and_their_end_once(bench: Bench) -> None:
    words = "timers are up to 1,240 ms late; load 30 on 2 cores"
    assert [bench.window(1240 * MS), bench.window(1240 * MS), bench.host.words] == [words, None, words]
    assert [bench.window() for _ in range(SETTLED_WINDOWS)] == [*[None] * (SETTLED_WINDOWS - 1), ""]
    assert bench.host.words == ""
    assert bench.host.facts()["worst_ms"] == 1240.0


def test_a_single_good_window_is_no_end(bench: Bench) -> None:
    told = [bench.window(LATE_NS), *(bench.window(number % 2 * LATE_NS) for number in range(20))]
    assert len([words for words in told if words is not None]) == 1


def test_a_ring_that_loses_cycles_is_told_of_with_the_share_that_it_keeps(bench: Bench) -> None:
    assert bench.window(late_cycles=590) == "ring keeps 41 % of its cycles; load 30 on 2 cores"


def test_a_ring_that_has_just_begun_is_not_judged(bench: Bench) -> None:
    assert bench.window(cycles=10, late_cycles=10) is None


@pytest.fixture
def said(monkeypatch: pytest.MonkeyPatch, bench: Bench) -> "Said":
    return Said(bench.lateness)


class Said:
    """The log of a process."""

    def __init__(self, lateness: Lateness) -> None:
        self._filter = LateRecords(lateness)

    def __call__(self, name: str, level: int, text: str, *arguments: object) -> str:
        record = logging.LogRecord(name, level, "", 0, text, arguments, None)
        assert self._filter.filter(record)
        return record.getMessage()


def test_a_warning_of_a_device_names_the_lateness_of_the_last_seconds(bench: Bench, said: Said) -> None:
    assert said("fieldrig_devices.pam", logging.WARNING, "stopped by %s", "F010") == "stopped by F010"
    bench.lateness.note(35 * MS)
    late = "stopped by F010 (the host was up to 35 ms late in the last seconds, load 30 on 2 cores)"
    assert said("fieldrig_devices.pam", logging.WARNING, "stopped by %s", "F010") == late
    bench.host.turn()
    assert said("fieldrig_bus.ring", logging.ERROR, "stopped by %s", "F010") == late
    bench.host.turn()
    assert said("fieldrig_devices.pam", logging.WARNING, "stopped by %s", "F010") == "stopped by F010"


@pytest.mark.parametrize(
    ("name", "level", "late_ns"),
    [
        ("fieldrig_devices.pam", logging.DEBUG, 35 * MS),
        ("fieldrig.storage.store", logging.WARNING, 35 * MS),
        ("fieldrig_devices.pam", logging.WARNING, NOTED_NS - 1),
    ],
)
def test_nothing_else_names_it(bench: Bench, said: Said, name: str, level: int, late_ns: int) -> None:
    bench.lateness.note(late_ns)
    assert said(name, level, "100 %") == "100 %"
