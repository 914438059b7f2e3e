"""Triggers of the scope beside a reference that looks at each sample; no batching makes them miss one."""

from collections.abc import Callable, Sequence
from itertools import pairwise
from math import isnan, nan
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scope_rows import cut_up, rows

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.scope.store import Track
from fieldrig_page.scope.triggers import Hit, Trigger, read_trigger

STATES = ("off", "ready", "on")

Rule = Callable[[float, float], bool]

# Each kind, and what it means for a sample and the known one before it.
RULES: dict[str, tuple[Trigger, Rule]] = {
    "rising": (Trigger("edge", "io/a", 1.0, what="rising"), lambda before, now: before < 1 <= now),
    "falling": (Trigger("edge", "io/a", 1.0, what="falling"), lambda before, now: now < 1 <= before),
    "both": (Trigger("edge", "io/a", 1.0, what="both"), lambda before, now: (before < 1) != (now < 1)),
    "state": (Trigger("state", "io/a", what="ready"), lambda before, now: before != 1 and now == 1),
    "inside": (
        Trigger("window", "io/a", 0.5, 1.0, "inside"),
        lambda before, now: not 0.5 <= before <= 1 and 0.5 <= now <= 1,
    ),
    "outside": (
        Trigger("window", "io/a", 0.5, 1.0, "outside"),
        lambda before, now: 0.5 <= before <= 1 and not 0.5 <= now <= 1,
    ),
}
SIDES: dict[str, tuple[Trigger, Callable[[float], bool]]] = {
    "above": (Trigger("level", "io/a", 1.0, what="above"), lambda now: now >= 1),
    "below": (Trigger("level", "io/a", 1.0, what="below"), lambda now: now < 1),
}

values = st.lists(st.sampled_from([0.0, 0.25, 0.5, 0.75, 1.0, 1.5, 2.0, nan]), min_size=1, max_size=120)
places = st.lists(st.integers(0, 120))


def hits(trigger: Trigger, samples: Sequence[float], cuts: Sequence[int], depth: int = 1 << 15) -> list[int]:
    """Instants of all hits, found in batches."""
    track, found, looked = Track(1, depth=depth), [], 0
    reach = trigger.range_of(STATES)
    for batch in cut_up(rows(range(0, 10 * len(samples), 10), samples), cuts):
        track.add(batch)
        while (hit := reach.first(track, 0, looked, track.end)) is not None:
            found.append(hit.instant_ns)
            looked = hit.number + 1
        looked = track.end
    return found


def changes(samples: Sequence[float], rule: Rule) -> list[int]:
    known = [(place * 10, value) for place, value in enumerate(samples) if not isnan(value)]
    return [at for (_, before), (at, now) in pairwise(known) if rule(before, now)]


@pytest.mark.parametrize("name", RULES)
@given(values, places)
def test_each_change_is_found_at_its_instant_for_any_batches(name: str, samples: list[float], cuts: list[int]) -> None:
    trigger, rule = RULES[name]
    assert hits(trigger, samples, cuts) == changes(samples, rule)


@pytest.mark.parametrize("name", SIDES)
@given(values, places)
def test_each_sample_on_the_side_of_a_level_is_a_hit(name: str, samples: list[float], cuts: list[int]) -> None:
    trigger, rule = SIDES[name]
    expected = [place * 10 for place, value in enumerate(samples) if not isnan(value) and rule(value)]
    assert hits(trigger, samples, cuts) == expected


@given(st.integers(1, 5000), st.lists(st.integers(0, 5001), max_size=40))
def test_a_pulse_of_one_sample_is_never_missed(place: int, cuts: list[int]) -> None:
    samples = [0.0] * 5001
    samples[place] = 1.0
    assert hits(RULES["rising"][0], samples, cuts, depth=4096) == [place * 10]


def test_an_edge_in_a_gap_is_shown_by_the_first_row_after_it() -> None:
    track = Track(1)
    track.add(rows([0, 10], [0.0, 0.0]))
    track.add(rows([50, 60], [1.0, 1.0], lost=3))
    found = RULES["rising"][0].range_of(()).first(track, 0, 0, track.end)
    assert found == Hit(number=3, instant_ns=50, after_ns=10)


def test_an_edge_between_two_rows_is_at_the_instant_of_the_second() -> None:
    track = Track(1)
    track.add(rows([0, 10], [0.0, 1.0]))
    assert RULES["rising"][0].range_of(()).first(track, 0, 0, track.end) == Hit(1, 10, 10)


def test_a_state_that_the_signal_does_not_have_is_refused_with_the_nearest() -> None:
    with pytest.raises(ControlError, match="did you mean ready"):
        Trigger("state", "io/a", what="raedy").range_of(STATES)
    with pytest.raises(ControlError, match="no states"):
        Trigger("state", "io/a", what="ready").range_of(())


def test_messages_and_faults_fit_by_their_words_and_their_part() -> None:
    message = read_trigger({"kind": "message", "part": "can0", "words": "185 EMCY"})
    assert message.fits_message("can0", "0x185 emcy 8130")
    assert not message.fits_message("can1", "0x185 emcy 8130")
    assert not message.fits_message("can0", "0x185")
    fault = read_trigger({"kind": "fault", "what": "end"})
    assert fault.fits_fault("io", is_over=True)
    assert not fault.fits_fault("io", is_over=False)
    assert not read_trigger({"kind": "fault", "part": "io"}).fits_fault("can0", is_over=False)


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (None, "expected an object"),
        ({"kind": "slope"}, "kind: expected one of edge, level"),
        ({"kind": "edge", "level": 1}, "signal"),
        ({"kind": "edge", "signal": "a/b", "level": "1"}, "level: expected a number"),
        ({"kind": "edge", "signal": "a/b", "level": float("nan")}, "level: expected a number"),
        ({"kind": "edge", "signal": "a/b", "level": 1, "what": "up"}, "what: expected one of rising"),
        ({"kind": "message", "part": "can0", "words": 5}, "words: expected"),
        ({"kind": "edge", "signal": "a/b", "level": 1, "edge": "falling"}, "'edge': expected one of kind, signal"),
    ],
)
def test_what_is_no_trigger_is_refused_with_its_key(data: Any, wrong: str) -> None:
    with pytest.raises(MalformedError, match=wrong):
        read_trigger(data)


@pytest.mark.long
@settings(max_examples=50)
@given(
    st.recursive(
        st.none() | st.booleans() | st.floats() | st.text(), lambda x: st.lists(x) | st.dictionaries(st.text(), x)
    )
)
def test_nothing_from_outside_raises_anything_else(data: Any) -> None:
    for kind in ("edge", "level", "state", "window", "message", "fault"):
        filled = {"kind": kind, "signal": "a/b", "level": data, "high": data, "what": data, "part": data, "words": data}
        for given_data in (data, filled):
            try:
                trigger = read_trigger(given_data)
            except MalformedError:
                continue
            assert read_trigger(trigger.as_data()) == trigger


def test_what_a_page_sends_while_a_trigger_is_chosen_is_no_reason_to_close_its_socket() -> None:
    assert read_trigger({"kind": "window", "signal": "a/b", "level": 2, "high": 1})[2:4] == (1, 2)
    assert not read_trigger({"kind": "message"}).fits_message("can0", "0x185")
    with pytest.raises(ControlError, match="no state ''"):
        read_trigger({"kind": "state", "signal": "a/b"}).range_of(STATES)
