"""The state of a part in one word, the load of a bus in a few, and the two points of a card."""

from collections.abc import Mapping
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_page.bus_load import Reading, kept_percent, load_words, numbers_of
from fieldrig_page.changes import Changes
from fieldrig_page.chosen_points import chosen, label_of
from fieldrig_page.part_faults import cuts, faults_of, power_off
from fieldrig_page.states import Level, Process, state_of_bus, state_of_device

ON = {"what": "drop", "count": 3, "state": "on"}
S = 1_000_000_000


def _nested(children: st.SearchStrategy[Any]) -> st.SearchStrategy[Any]:
    words = st.sampled_from(["1", "2", "x", "what", "state", "frames", "cycles", "load_percent", "late.a"])
    return st.lists(children, max_size=2) | st.dictionaries(words, children, max_size=4)


@pytest.mark.parametrize(
    ("process", "faults", "troubles", "expected"),
    [
        (Process(), {}, {}, (Level.OK, "ready")),
        (Process("dead"), {}, {}, (Level.DOWN, "down")),
        (Process("gone"), {1: ON}, {}, (Level.DOWN, "down")),
        (Process("starting"), {}, {}, (Level.LATE, "starting")),
        (Process(late="timers are up to 90 ms late"), {}, {}, (Level.LATE, "late")),
        (Process(), {1: {"what": "power_off", "state": "on"}}, {}, (Level.DOWN, "power off")),
        (Process(), {1: {"what": "power_off", "state": "over"}}, {}, (Level.OK, "ready")),
        (Process(late="late"), {1: ON}, {}, (Level.FAULT, "drop")),
        (Process(), {1: {"what": "level_sensor_sticks", "state": "on"}}, {}, (Level.FAULT, "level sensor sticks")),
        (Process(), {1: {**ON, "state": "waiting"}}, {}, (Level.OK, "ready")),
        (Process(is_silent=True), {1: ON}, {"diag_code": 201}, (Level.DOWN, "no answer")),
        (Process("dead", is_silent=True), {}, {}, (Level.DOWN, "down")),
        (Process("starting", is_silent=True), {}, {}, (Level.LATE, "starting")),
        (Process(), {}, {"diag_code": 201}, (Level.FAULT, "trouble")),
        (Process(), {}, {"diag_code": 0}, (Level.OK, "ready")),
        (Process(), {}, {"error": 0, "warning": 204}, (Level.LATE, "warning")),
        (Process(), {}, {"error": 25, "warning": 204}, (Level.FAULT, "trouble")),
    ],
)
def test_a_device_has_one_word_and_a_level(
    process: Process, faults: Mapping[int, Any], troubles: Mapping[str, Any], expected: tuple[Level, str]
) -> None:
    state = state_of_device(process, faults, troubles)
    assert (state.level, state.word) == expected


def test_a_state_says_why() -> None:
    state = state_of_device(Process(), {1: ON}, {"diag_code": 201})
    assert state.why == ("fault: drop count=3", "diag_code 201")


@pytest.mark.parametrize(
    ("conditions", "figures", "expected"),
    [
        ({}, {}, (Level.OK, "ready")),
        ({"cell.enable": "emergency stop"}, {}, (Level.FAULT, "alarm")),
        ({"ring": "the ring is open"}, {"ring_closed": 0.0, "cycles": 12.0}, (Level.FAULT, "open")),
        ({}, {"ring_closed": 0.0, "cycles": 0.0}, (Level.OK, "ready")),  # it has not been closed yet
        ({}, {"ring_closed": 1.0, "cycles": 12.0}, (Level.OK, "ready")),
    ],
)
def test_a_bus_has_one_word_and_a_level(
    conditions: Mapping[str, str], figures: Mapping[str, float], expected: tuple[Level, str]
) -> None:
    state = state_of_bus(Process(), {}, conditions, figures)
    assert (state.level, state.word) == expected
    assert state.why == tuple(conditions.values())


@pytest.mark.parametrize(
    ("before", "now", "words"),
    [
        (None, {"load_percent": 12.4, "frames": 9.0}, "12.4 %"),
        ({"cycles": 0.0}, {"cycles": 250.0}, "4 ms"),
        ({"cycles": 0.0, "late_cycles": 0.0}, {"cycles": 500.0, "late_cycles": 10.0}, "2 ms, 98 % kept"),
        ({"cycles": 9.0}, {"cycles": 9.0}, "no cycles"),
        ({"requests": 10.0}, {"requests": 13.0}, "3 requests/s"),
        ({"requests": 10.0}, {"requests": 10.5}, "0.5 requests/s"),
        ({"requests": 10.0}, {"requests": 2.0}, "0 requests/s"),  # its process has started again
        (None, {"requests": 10.0}, ""),
        (None, {"wires": 8.0}, "8 wires"),
        (None, {}, ""),
    ],
)
def test_the_load_of_a_bus(before: Mapping[str, float] | None, now: Mapping[str, float], words: str) -> None:
    assert load_words(None if before is None else Reading(0, before), Reading(S, now)) == words


def test_the_share_of_cycles_that_each_station_keeps() -> None:
    before = Reading(0, {"cycles": 100.0, "late_cycles": 1.0, "late.a": 1.0, "late.b": 0.0})
    now = Reading(S, {"cycles": 300.0, "late_cycles": 21.0, "late.a": 21.0, "late.b": 0.0})
    assert kept_percent(before, now) == {"a": 90, "b": 100}
    assert kept_percent(None, now) == kept_percent(now, now) == {}
    assert kept_percent(before, Reading(S, {"requests": 1.0})) == {}


@pytest.mark.parametrize(
    ("keys", "named", "expected"),
    [
        (["high", "volume", "level"], (), ["level", "high"]),
        (["torque", "speed", "position"], (), ["position", "speed"]),
        (["state", "error", "axis1.position", "axis1.speed", "axis2.speed"], (), ["axis1.position", "axis1.speed"]),
        (["1000:00", "6000:01", "6130:01", "nmt.state"], ("6000:01.5", "6130:01"), ["6000:01", "6130:01"]),
        (["1000:00", "6064:00", "606C:00"], (), ["6064:00", "606C:00"]),
        (["I_a", "display", "state"], (), ["state", "display"]),
        (["a", "b", "c"], (), ["a", "b"]),
        ([], (), []),
    ],
)
def test_a_card_shows_the_most_telling_points(keys: list[str], named: tuple[str, ...], expected: list[str]) -> None:
    assert chosen({key: {"unit": "", "writable": False} for key in keys}, named) == expected


def test_an_object_is_called_by_its_name() -> None:
    assert label_of("6000:01", "Read inputs byte 1") == "Read inputs byte 1"
    assert label_of("level", "of the water above the outlet") == "level"
    assert label_of("drive_temperature", "") == "drive temperature"


def test_a_reader_gets_what_is_new_for_it() -> None:
    values: Changes[int] = Changes()
    values.put("a", 1)
    seen = values.number
    values.put("b", 2)
    values.put("a", 1)
    assert values.since(0) == {"a": 1, "b": 2}
    assert values.since(seen) == {"b": 2}
    assert values.since(values.number) == {}


@given(st.recursive(st.none() | st.integers() | st.floats() | st.text(max_size=3), _nested, max_leaves=8))
def test_whatever_a_kind_of_a_user_answers_is_taken(answer: Any) -> None:
    faults, figures = faults_of(answer), numbers_of(answer)
    state_of_device(Process(), faults, {})
    state_of_bus(Process(), faults, {}, figures)
    load_words(Reading(0, figures), Reading(S, figures))
    assert cuts(faults) == {}
    assert power_off(faults) is None
