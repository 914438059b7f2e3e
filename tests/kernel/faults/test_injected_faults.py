"""Faults of a running device: what is typed, when they are on, and what the device hears of it."""

from typing import Annotated, Any, Literal

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import Field

from fieldrig.clock import MS, VirtualClock
from fieldrig.faults.faults import Fault, Faults, Timed, fault_of, models_of
from fieldrig.faults.injected import InjectedFaults


class Stuck(Timed):
    what: Literal["stuck"]
    at: Literal["low", "high"] = "low"
    label: Annotated[str, Field(min_length=1)] | None = None
    volts: int | None = None


class Open(Timed):
    what: Literal["open"]


MODELS = models_of(Annotated[Stuck | Open, Field(discriminator="what")])


class Bench:
    def __init__(self, check: Any = None) -> None:
        self.clock = VirtualClock()
        self.changes: list[tuple[int, bool]] = []
        self.faults = InjectedFaults[Fault[Any]](
            self.clock, MODELS, Faults(Fault), on_change=self._on_change, check=check
        )

    def _on_change(self) -> None:
        self.changes.append((self.clock.now_ns(), self.faults.first(Stuck) is not None))

    def run_until(self, ns: int) -> None:
        self.clock.advance_to(ns)


def test_device_hears_of_every_beginning_and_end() -> None:
    bench = Bench()
    assert bench.faults.add_fault({"what": "stuck", "start_ms": "2", "duration_ms": "3"}) == 1
    bench.run_until(10 * MS)
    assert bench.changes == [(0, False), (2 * MS, True), (5 * MS, False)]
    assert bench.faults.faults()[1]["state"] == "over"
    bench.faults.clear_fault(1)
    assert bench.changes[-1] == (10 * MS, False)
    assert bench.faults.faults() == {}


@given(st.integers(0, 50), st.integers(1, 50), st.integers(0, 120))
def test_a_fault_is_on_from_its_start_until_its_end(start_ms: int, duration_ms: int, at_ms: int) -> None:
    bench = Bench()
    bench.faults.add_fault({"what": "stuck", "start_ms": start_ms, "duration_ms": duration_ms, "at": "high"})
    bench.run_until(at_ms * MS)
    is_on = start_ms <= at_ms < start_ms + duration_ms
    assert [settings.at for settings in bench.faults.active(Stuck)] == ["high"] * is_on
    assert list(bench.faults.active(Open)) == []


def test_first_is_the_one_that_was_added_first() -> None:
    bench = Bench()
    bench.faults.add_fault({"what": "stuck", "at": "high", "duration_ms": 1})
    bench.faults.add_fault({"what": "stuck", "at": "low"})
    first = bench.faults.first(Stuck)
    assert first is not None
    assert first.at == "high"
    bench.run_until(MS)
    assert [settings.at for settings in bench.faults.active(Stuck)] == ["low"]


@pytest.mark.parametrize("typed", ["0102", "1e3", "true", "[a]"])
def test_a_text_stays_a_text_and_a_number_becomes_one(typed: str) -> None:
    settings = fault_of({"what": "stuck", "label": typed, "volts": "0x10"}, MODELS)
    assert isinstance(settings, Stuck)
    assert (settings.label, settings.volts) == (typed, 16)


@pytest.mark.parametrize(
    ("fault", "wrong"),
    [
        ({"what": "stick"}, "there is no fault 'stick'\n.*stuck"),
        ({}, "what: this key is missing"),
        ({"what": "stuck", "at": "middle"}, "at: "),
        ({"what": "stuck", "volts": "much"}, "volts: "),
        ({"what": "open", "volts": "1"}, "volts: "),
    ],
)
def test_what_is_no_fault_is_refused(fault: dict[str, Any], wrong: str) -> None:
    bench = Bench()
    with pytest.raises(ValueError, match=wrong):
        bench.faults.add_fault(fault)
    assert (bench.changes, bench.faults.given) == ([], 0)


def test_a_device_can_refuse_a_fault_that_cannot_be() -> None:
    def check(settings: Timed) -> None:
        if isinstance(settings, Open):
            raise ValueError("there is no wire to open")

    bench = Bench(check)
    bench.faults.add_fault({"what": "stuck"})
    with pytest.raises(ValueError, match="no wire to open"):
        bench.faults.add_fault({"what": "open"})
    with pytest.raises(ValueError, match="there is no fault 2\nthere are: 1"):
        bench.faults.clear_fault(2)
    assert list(bench.faults.faults()) == [1]


def test_a_fault_that_is_a_state_is_applied_when_it_begins() -> None:
    bench = Bench()
    bench.faults.add_fault({"what": "stuck", "start_ms": 2, "duration_ms": 3})
    bench.faults.add_fault({"what": "open", "when": "io/level > 1"})
    bench.run_until(2 * MS - 1)
    assert [fault["applied"] for fault in bench.faults.faults().values()] == [0, 0]
    bench.run_until(2 * MS)
    bench.faults.begin(2)
    assert [fault["applied"] for fault in bench.faults.faults().values()] == [1, 1]
    bench.run_until(9 * MS)
    assert bench.faults.faults()[1] == {"what": "stuck", "duration_ms": 3, "start_ms": 2, "state": "over", "applied": 1}
