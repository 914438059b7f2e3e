"""A search skips the nominal run before an action: a run from a branch on its way is the one from the begin."""

from collections.abc import Iterator

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lamp_search import HISTORY, PLAN, TWO_BUGS, planted

from fieldrig.clock import MS, S
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.search import run
from fieldrig_devices.search.crew import Bench
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import load_plan

pytestmark = [pytest.mark.lean, pytest.mark.long]

LENGTH_NS = 2 * S
STEPS = "- {at: 100ms, set: {wires/switch.on: true}}\n- {at: 600ms, set: {wires/switch.on: false}}"
KEYS = "- {at: 100ms, press: {wires/switch.on: true}, hold: 400ms}\n- {at: 750ms, set: {wires/switch.on: false}}"
"""A key that is released at a mark of the trunk, and a step at another one."""


@pytest.fixture(scope="module", params=[HISTORY, TWO_BUGS])
def bench(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Bench]:
    folder = tmp_path_factory.mktemp("trunk")
    with Bench(load_plan(planted(folder, request.param, PLAN.replace(STEPS, KEYS)))) as made:
        yield made


def from_the_begin(bench: Bench, piece: Piece) -> Run:
    with bench.root.branch() as branch:
        return branch.call(run.play_piece, piece)


def same(one: Run, other: Run) -> bool:
    return one._replace(cpu_s=0.0) == other._replace(cpu_s=0.0)


INSTANTS_MS = st.one_of(st.sampled_from([0, 100, 125, 250, 500, 750]), st.integers(0, 1999))
ACTS = st.tuples(INSTANTS_MS, st.sampled_from(["set", "press"]), st.booleans(), st.sampled_from([20, 50, 125, 250]))


def acts_of(drawn: list[tuple[int, str, bool, int]]) -> Schedule:
    acts = [
        Act(
            at_ms * MS,
            "press" if verb == "press" else "set",
            "wires/switch.on",
            level,
            hold_ms * MS * (verb == "press"),
        )
        for at_ms, verb, level, hold_ms in drawn
    ]
    return tuple(sorted(acts, key=lambda act: act.at_ns))


@settings(max_examples=25, deadline=None)
@given(drawn=st.lists(ACTS, min_size=1, max_size=4))
def test_a_run_from_a_mark_is_the_one_from_the_begin(bench: Bench, drawn: list[tuple[int, str, bool, int]]) -> None:
    piece = Piece(acts_of(drawn), 0, LENGTH_NS)
    assert same(bench.play(piece), from_the_begin(bench, piece))


@settings(max_examples=15, deadline=None)
@given(act=ACTS, begin_ms=INSTANTS_MS)
def test_a_piece_from_an_instant_is_the_one_from_the_begin(
    bench: Bench, act: tuple[int, str, bool, int], begin_ms: int
) -> None:
    """A sweep goes to and fro between its instants; an archive looks at the states as well."""
    [one] = acts_of([(begin_ms, *act[1:])])
    for piece in (
        Piece((one,), one.at_ns, LENGTH_NS),
        Piece((one,), one.at_ns, one.at_ns + 300 * MS, is_whole=False),
    ):
        assert same(bench.play(piece), from_the_begin(bench, piece))
