"""The judge against another one that is slow and plain: it looks at the whole history of values for each property."""

from collections.abc import Sequence
from typing import NamedTuple

from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.judge import Judge
from fieldrig_devices.scenarios.property import Kind, Property

END_MS = 40
NAMES = ("p", "q", "r")
State = tuple[bool, bool, bool]


class Moment(NamedTuple):
    """The values at one look of the judge."""

    at_ms: int
    state: State


def history(events: Sequence[tuple[int, int, bool]]) -> list[Moment]:
    """Return all looks: one at the begin, one for each change, and one in each millisecond."""
    state, moments, waiting = (
        [False, False, False],
        [Moment(0, (False, False, False))],
        sorted(events, key=lambda one: one[0]),
    )
    for at_ms in range(END_MS + 1):
        for _, name, value in (one for one in waiting if one[0] == at_ms):
            state[name] = value
            moments.append(Moment(at_ms, (state[0], state[1], state[2])))
        moments.append(Moment(at_ms, (state[0], state[1], state[2])))
    return moments


def rises(moments: Sequence[Moment], name: int | None) -> list[int]:
    """Return the numbers of the looks at which a value becomes true; the first one if there is none."""
    if name is None:
        return [0]
    was = [False, *(moment.state[name] for moment in moments)]
    return [number for number in range(len(moments)) if moments[number].state[name] and not was[number]]


def expected(
    kind: Kind, moments: Sequence[Moment], after: int | None, within_ms: int | None, healed_ms: int
) -> int | None:
    """Return the instant of the first violation by the words of the manual, in milliseconds; the condition is `p`."""
    begins = rises(moments, after)
    match kind:
        case Kind.ALWAYS | Kind.NEVER:
            return _wrong_for(moments, begins, kind is Kind.ALWAYS, within_ms)
        case Kind.WITHIN:
            assert within_ms is not None
            return min(filter(None, (_missed(moments, begin, within_ms) for begin in begins)), default=None)
        case Kind.STAYS:
            left = (_left(moments, begin) for begin in begins)
            return min((at_ms for at_ms in left if at_ms is not None), default=None)
    assert within_ms is not None
    before = [state for at_ms, state in moments if at_ms < healed_ms][-1:]  # which is so still when the faults are over
    after_it = [state for at_ms, state in moments if healed_ms <= at_ms <= healed_ms + within_ms]
    met = any(state[0] for state in (*before, *after_it))
    return None if met else healed_ms + within_ms


def _wrong_for(moments: Sequence[Moment], begins: Sequence[int], wanted: bool, longer_ms: int | None) -> int | None:
    """Return when the condition was wrong for longer than it may be, from the first begin on."""
    if not begins:
        return None
    since: int | None = None
    for at_ms, state in moments[begins[0] :]:
        if since is not None and longer_ms is not None and at_ms > since + longer_ms:
            return since + longer_ms
        if state[0] is wanted:
            since = None
        elif longer_ms is None:
            return at_ms
        elif since is None:
            since = at_ms
    return since + longer_ms if since is not None and longer_ms is not None and since + longer_ms <= END_MS else None


def _missed(moments: Sequence[Moment], begin: int, within_ms: int) -> int | None:
    due_ms = moments[begin].at_ms + within_ms
    came = any(state[0] for at_ms, state in moments[begin:] if at_ms <= due_ms)
    return None if came or due_ms > END_MS else due_ms


def _left(moments: Sequence[Moment], begin: int) -> int | None:
    """Return when `p` was not true before `r` was."""
    for at_ms, state in moments[begin:]:
        if state[2]:
            return None
        if not state[0]:
            return at_ms
    return None


EVENTS = st.lists(st.tuples(st.integers(0, END_MS), st.integers(0, 2), st.booleans()), max_size=12)
RULES = st.tuples(st.sampled_from(list(Kind)), st.sampled_from([None, 1]), st.one_of(st.none(), st.integers(1, 30)))


@given(EVENTS, RULES, st.integers(0, END_MS))
def test_both_judges_agree(
    events: list[tuple[int, int, bool]], rule: tuple[Kind, int | None, int | None], healed_ms: int
) -> None:
    kind, after, within_ms = rule
    if kind in (Kind.WITHIN, Kind.EVENTUALLY) and within_ms is None:
        within_ms = 7
    if kind is Kind.STAYS:
        within_ms = None
    if kind is Kind.EVENTUALLY:
        after = None
    asked = Property(
        "it",
        kind,
        expression_of("m/p"),
        None if after is None else expression_of("m/q"),
        expression_of("m/r") if kind is Kind.STAYS else None,
        None if within_ms is None else within_ms * MS,
    )
    moments = history(events)
    judge = Judge([asked], {f"m/{name}": False for name in NAMES})
    healed = False
    for (at_ms, state), (_, before) in zip(moments[1:], moments, strict=False):
        if at_ms >= healed_ms and not healed:
            judge.healed(healed_ms * MS)
            healed = True
        for name, value, old in zip(NAMES, state, before, strict=True):
            if value is not old:
                judge.change(at_ms * MS, f"m/{name}", value)
        judge.look(at_ms * MS)
    judge.end(END_MS * MS)
    found = [one.at_ns // MS for one in judge.violations]
    first = expected(kind, moments, after, within_ms, healed_ms)
    assert found == ([] if first is None else [first])
