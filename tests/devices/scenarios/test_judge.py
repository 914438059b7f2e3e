"""Each kind of property, judged over changes and instants that are written by hand."""

from collections.abc import Sequence

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.judge import Judge
from fieldrig_devices.scenarios.property import Kind, Property

Changes = Sequence[tuple[int, str, object]]
START = {"m/run": False, "m/go": False, "m/stop": False, "m/level": 0.0}


def rule(kind: Kind, condition: str, after: str = "", until: str = "", within_ms: int | None = None) -> Property:
    return Property(
        "it",
        kind,
        expression_of(condition),
        expression_of(after) if after else None,
        expression_of(until) if until else None,
        None if within_ms is None else within_ms * MS,
    )


def judged(one: Property, changes: Changes, end_ms: int = 1000, healed_ms: int | None = None) -> list[int]:
    """Return the instants of violations in milliseconds."""
    judge = Judge([one], START)
    for at_ms, place, value in changes:
        if healed_ms is not None and at_ms >= healed_ms:
            judge.healed(healed_ms * MS)
            healed_ms = None
        judge.change(at_ms * MS, f"m/{place}", value)  # type: ignore[arg-type]
        judge.look(at_ms * MS)
    if healed_ms is not None:
        judge.healed(healed_ms * MS)
    judge.end(end_ms * MS)
    return [found.at_ns // MS for found in judge.violations]


@pytest.mark.parametrize(
    ("one", "changes", "expected"),
    [
        (rule(Kind.NEVER, "m/run and m/stop"), [(10, "run", True), (20, "stop", True)], [20]),
        (rule(Kind.NEVER, "m/run"), [(10, "run", True), (10, "run", False)], [10]),  # a pulse within an instant
        (rule(Kind.NEVER, "m/run", "m/go"), [(10, "run", True), (20, "run", False), (30, "go", True)], []),
        (rule(Kind.NEVER, "m/run", "m/go"), [(10, "run", True), (30, "go", True)], [30]),
        (rule(Kind.NEVER, "m/run", "m/go"), [(10, "go", True), (20, "go", False), (30, "run", True)], [30]),
        (rule(Kind.NEVER, "m/run", within_ms=20), [(10, "run", True), (30, "run", False)], []),
        (rule(Kind.NEVER, "m/run", within_ms=20), [(10, "run", True), (31, "run", False)], [30]),
        (rule(Kind.NEVER, "m/run", within_ms=20), [(10, "run", True), (20, "run", False), (25, "run", True)], [45]),
        (rule(Kind.ALWAYS, "m/run", within_ms=20), [], [20]),
        (rule(Kind.ALWAYS, "m/level < 5"), [(10, "level", 4.9), (20, "level", 5.0), (30, "level", 9.0)], [20]),
        (rule(Kind.ALWAYS, "m/run"), [], [0]),
        (rule(Kind.ALWAYS, "m/run", "m/run"), [(10, "run", True), (20, "run", False)], [20]),
        (rule(Kind.WITHIN, "m/run", "m/go", within_ms=50), [(10, "go", True), (60, "run", True)], []),
        (rule(Kind.WITHIN, "m/run", "m/go", within_ms=50), [(10, "go", True), (61, "run", True)], [60]),
        (rule(Kind.WITHIN, "m/run", "m/go", within_ms=50), [(10, "go", True)], [60]),
        (rule(Kind.WITHIN, "m/run", "m/go", within_ms=50), [(990, "go", True)], []),  # the end comes first
        (rule(Kind.WITHIN, "m/run", within_ms=50), [(40, "run", True), (45, "run", False)], []),
        (rule(Kind.WITHIN, "m/run", within_ms=50), [], [50]),
        (
            rule(Kind.WITHIN, "m/run", "m/go", within_ms=50),
            [(10, "go", True), (20, "run", True), (30, "run", False), (40, "go", False), (50, "go", True)],
            [100],
        ),
        (rule(Kind.STAYS, "m/run", "m/go", "m/stop"), [(5, "run", True), (10, "go", True), (20, "run", False)], [20]),
        (rule(Kind.STAYS, "m/run", "m/go", "m/stop"), [(10, "go", True)], [10]),
        (
            rule(Kind.STAYS, "m/run", "m/go", "m/stop"),
            [(5, "run", True), (10, "go", True), (20, "stop", True), (30, "run", False)],
            [],
        ),
        (rule(Kind.STAYS, "not m/run", "m/go", "m/stop", 30), [(10, "go", True), (50, "stop", True)], [40]),
    ],
)
def test_each_kind(one: Property, changes: Changes, expected: list[int]) -> None:
    assert judged(one, changes) == expected


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        ([(10, "run", True), (20, "run", False)], [300]),  # before the faults are over it does not count
        ([(10, "run", True)], []),
        ([(250, "run", True)], []),
        ([(301, "run", True)], [300]),
    ],
)
def test_a_machine_comes_back_when_all_faults_are_over(changes: Changes, expected: list[int]) -> None:
    assert judged(rule(Kind.EVENTUALLY, "m/run", within_ms=200), changes, healed_ms=100) == expected


def test_the_end_does_not_judge_a_recovery_for_which_there_was_no_time() -> None:
    assert judged(rule(Kind.EVENTUALLY, "m/run", within_ms=200), [], end_ms=250, healed_ms=100) == [300]


def test_a_violation_has_the_values_and_a_reason() -> None:
    judge = Judge([rule(Kind.WITHIN, "m/run", "m/go", within_ms=50)], START)
    judge.change(10 * MS, "m/go", True)
    judge.look(100 * MS)
    [found] = judge.violations
    assert found.what == "`m/run` was not true within 0.05 s of `m/go` at 0.01 s"
    assert dict(found.values) == {"m/run": False, "m/go": True}


EVENTS = st.lists(st.tuples(st.integers(0, 20), st.sampled_from(["run", "go"]), st.booleans()), max_size=20)


@given(EVENTS)
def test_never_is_the_opposite_of_always(events: list[tuple[int, str, bool]]) -> None:
    changes = sorted(events, key=lambda event: event[0])
    for condition in ("m/run and m/go", "m/run or m/go"):
        never = judged(rule(Kind.NEVER, condition), changes)
        assert never == judged(rule(Kind.ALWAYS, f"not ({condition})"), changes)


@given(EVENTS, st.integers(1, 10))
def test_within_agrees_with_a_plain_search_through_the_changes(
    events: list[tuple[int, str, bool]], within_ms: int
) -> None:
    changes = sorted(events, key=lambda event: event[0])
    states, now = [(0, dict(START))], dict(START)
    for at_ms, place, value in changes:
        now = {**now, f"m/{place}": value}
        states.append((at_ms, now))
    due, was, late = None, False, list[int]()
    for at_ms, values in [*states, (1000, now)]:
        if due is not None and at_ms > due:
            late.append(due)
            break
        if values["m/go"] and not was and due is None:
            due = at_ms + within_ms
        was = bool(values["m/go"])
        due = None if values["m/run"] else due
    assert judged(rule(Kind.WITHIN, "m/run", "m/go", within_ms=within_ms), changes) == late
