"""A served rig that goes back: what it is then is what a rig is that never went on."""

import asyncio
import os
from collections.abc import Iterator
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fieldrig import MS, ControlError, Rig, RigError, S, from_dict
from fieldrig.clock import NEVER_NS
from fieldrig.config.rig_file import RigConfig
from fieldrig.virtual import checkpoints, journey, served
from fieldrig.virtual.journey import Journey, Search
from fieldrig.virtual.keeper import EACH, keep, why_no_way_back

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
]
HERE = Path(__file__).parents[1]
SLICE_S = 60.0
"""Longer than any slice of these tests."""


def config_of(**more: Any) -> RigConfig:
    rig = {
        "time": "virtual",
        "buses": {"wires": {"kind": "wires.virtual"}},
        "devices": {
            "dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}},
            "slow": {"kind": "rig_kinds:Dice", "period_ms": 35, "links": {"wires": "wires"}},
        },
    }
    return from_dict({**rig, **more}, HERE)


@contextmanager
def journey_of(config: RigConfig | None = None) -> Iterator[Journey]:
    kept = keep(config or config_of())
    kept.wait_until_built()
    kept.trace_hash()
    with closing(Journey(kept)) as made:
        yield made


@pytest.fixture(autouse=True)
def dense(monkeypatch: pytest.MonkeyPatch) -> None:
    """Checkpoints every 50 ms, of which six are kept, so that short runs have a past of many pieces."""
    monkeypatch.setattr(journey, "PERIOD_NS", 50 * MS)
    monkeypatch.setattr(journey, "KEEP", 6)
    monkeypatch.setattr(journey, "WINDOWS_NS", (MS, 20 * MS))
    monkeypatch.setattr(journey, "SPACING_S", 0.0)


def state(rig: Any) -> tuple[Any, ...]:
    return rig.now_ns, rig.trace_hash(), rig.get("dice/throws"), rig.get("slow/throws")


# ---- random programs, each step at its instant

Step = tuple[int, str, int]
STEPS = st.lists(
    st.tuples(st.integers(0, 80), st.sampled_from(["set", "rethrow", "loaded", "restart"]), st.integers(1, 40)),
    max_size=8,
)


def act(rig: Rig | Journey, what: str, number: int) -> None:
    match what:
        case "set":
            rig.set("dice", "throws", number)
        case "rethrow":
            rig.answer("slow", "rethrow", {"times": number})
        case "loaded":
            rig.add_fault("dice", {"what": "loaded", "duration_ms": number})
        case "restart":
            rig.restart("slow")


@pytest.mark.long
@settings(max_examples=6, deadline=None)
@example(steps=[(25, "set", 7), (0, "loaded", 30), (60, "restart", 1)], targets=[0.9, 0.4], later=[(5, "set", 3)])
@given(steps=STEPS, targets=st.lists(st.floats(0, 1), min_size=1, max_size=3), later=STEPS)
def test_a_rig_that_went_back_is_one_that_never_went_on(
    steps: list[Step], targets: list[float], later: list[Step]
) -> None:
    with journey_of() as travelled:
        done = [*play(travelled, 0, steps)]
        end_ns = travelled.now_ns + 100 * MS
        travelled.play(end_ns, SLICE_S)
        for target in targets:
            back_ns = round(target * travelled.now_ns)
            travelled.back(back_ns)
            done = [step for step in done if step[0] < back_ns]
            with straight(done, back_ns) as expected:
                assert state(travelled.rig) == state(expected)
        done += play(travelled, travelled.now_ns, later)
        travelled.play(travelled.now_ns + 70 * MS, SLICE_S)
        with straight(done, travelled.now_ns) as expected:
            assert state(travelled.rig) == state(expected)


def play(rig: Journey, now_ns: int, steps: list[Step]) -> Iterator[tuple[int, str, int]]:
    """Let the rig run and do each step, and yield them with their instants."""
    for after_ms, what, number in steps:
        now_ns += after_ms * MS
        rig.play(now_ns, SLICE_S)
        while rig.now_ns < now_ns:
            rig.play(now_ns, SLICE_S)
        act(rig, what, number)
        yield now_ns, what, number


@contextmanager
def straight(steps: list[Step], until_ns: int) -> Iterator[Rig]:
    """Yield a rig that has never been branched, in this process, after the same."""
    with Rig(config_of()) as rig:
        rig.trace_hash()
        for at_ns, what, number in steps:
            rig.run_until(at_ns)
            act(rig, what, number)
        rig.run_until(until_ns)
        yield rig


# ---- the way back


def run_to(rig: Journey, until_ns: int) -> None:
    while not rig.play(until_ns, SLICE_S).is_reached:
        pass


def test_there_is_a_first_instant_and_no_way_to_the_future() -> None:
    with journey_of() as travelled:
        run_to(travelled, 300 * MS)
        with pytest.raises(ControlError, match=r"cannot go back to 0\.4 s: it is at 0\.3 s"):
            travelled.back(400 * MS)
        travelled.back(0)
        assert travelled.now_ns == travelled.first_ns == 0
        run_to(travelled, 300 * MS)


def test_what_was_asked_beyond_a_limit_is_forgotten_with_the_first_checkpoints(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checkpoints, "MOST_ASKED", 10)
    with journey_of() as travelled, Rig(config_of()) as expected:
        expected.trace_hash()
        for number in range(1, 40):
            run_to(travelled, number * 20 * MS)
            expected.run_until(number * 20 * MS)
            travelled.set("dice", "throws", number)
            expected.set("dice", "throws", number)
        run_to(travelled, S)
        first_ns = travelled.first_ns
        assert first_ns is not None
        assert first_ns > 500 * MS
        with pytest.raises(ControlError, match="the first instant that it remembers"):
            travelled.back(first_ns - 1)
        travelled.back(S - MS)
        expected.run_until(S - MS)
        assert state(travelled.rig) == state(expected)


def test_a_rig_that_sleeps_has_one_checkpoint_and_not_thousands() -> None:
    rare = config_of(devices={"dice": {"kind": "rig_kinds:Dice", "period_ms": 3_600_000, "links": {"wires": "wires"}}})
    with journey_of(rare) as travelled:
        slices = 0
        while travelled.now_ns < 36_000 * S:
            travelled.play(None, SLICE_S)
            slices += 1
        assert slices < 100
        travelled.back(7_200 * S)
        assert travelled.rig.get("dice/throws") == 3


def test_a_fast_rig_has_no_checkpoint_until_its_time_has_come_and_goes_back_all_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    parked: list[int] = []
    take = checkpoints.Checkpoints.take

    def counted(self: checkpoints.Checkpoints, is_fixed: bool = False) -> None:
        take(self, is_fixed)
        parked.append(self.instants()[-1])

    monkeypatch.setattr(checkpoints.Checkpoints, "take", counted)
    with journey_of() as travelled, Rig(config_of()) as expected:
        expected.trace_hash()
        run_to(travelled, 70 * MS)
        assert parked == [0, 50 * MS]
        monkeypatch.setattr(journey, "SPACING_S", 1e9)
        run_to(travelled, 520 * MS)
        assert parked == [0, 50 * MS]
        monkeypatch.setattr(journey, "SPACING_S", 0.0)
        run_to(travelled, 560 * MS)
        assert parked == [0, 50 * MS, 550 * MS]
        travelled.back(430 * MS)
        expected.run_until(430 * MS)
        assert state(travelled.rig) == state(expected)


def test_processes_of_their_own_cannot_go_back() -> None:
    assert why_no_way_back(config_of(processes="each")) == EACH
    with closing(Journey(served.ServedRig(config_of()), EACH)) as travelled:
        run_to(travelled, 30 * MS)
        assert travelled.first_ns is None
        with pytest.raises(ControlError, match="`processes: each` cannot go back"):
            travelled.back(0)
        assert travelled.rig.get("dice/throws") == 4


def test_a_rig_that_cannot_be_built_says_so_where_it_is_waited_for() -> None:
    broken = config_of(devices={"wrong": {"kind": "rig_kinds:Unbuildable", "links": {"wires": "wires"}}})
    kept = keep(broken)
    with kept, pytest.raises(RigError, match="no such thing"):
        kept.wait_until_built()


def test_a_keeper_ends_with_its_pipe_and_nothing_of_it_stays() -> None:
    with journey_of() as travelled:
        run_to(travelled, 200 * MS)
        travelled.back(100 * MS)
        pid = travelled.rig.pid
    for _ in range(1000):
        try:
            os.kill(pid, 0)
        except ProcessLookupError:
            break
        os.sched_yield()


# ---- what listeners and readers get


def test_messages_come_in_slices_of_the_buses_that_are_listened_to() -> None:
    with journey_of() as travelled:
        assert travelled.play(20 * MS, SLICE_S).news.heard == []
        travelled.rig.hear(["wires"])
        heard = travelled.play(40 * MS, SLICE_S).news.heard
        assert [(bus, delivery.time_ns // MS, delivery.sender) for bus, delivery in heard] == [
            ("wires", 30, "dice"),
            ("wires", 35, "slow"),
            ("wires", 40, "dice"),
        ]
        travelled.back(25 * MS)
        assert travelled.play(40 * MS, SLICE_S).news.heard == []  # a branch of the past has no listeners


def test_a_recording_has_the_same_samples_as_in_this_process() -> None:
    with journey_of() as travelled, Rig(config_of()) as rig:
        here = rig.record(["dice/throws"], 5 * MS)
        begun = travelled.rig.begin_recording("1", ["dice/throws"], 5 * MS)
        assert [column.name for column in begun.columns] == ["dice/throws"]
        rig.run_until(100 * MS)
        run_to(travelled, 100 * MS)
        recorded = travelled.rig.of_recording("1", "flush")
        batches = [data for name, data in travelled.rig.news().batches if name == "1"]
        assert recorded.next == len(batches) > 0
        assert len(here.values["dice/throws"]) == 20
        hashes = travelled.rig.trace_hash()
        travelled.back(0)
        run_to(travelled, 100 * MS)
        assert travelled.rig.trace_hash() == hashes  # recording was no event


# ---- searching the past

THROWS = Search("dice", "thrown", {"wanted": 6}, {"found": True})


@pytest.mark.long
@settings(max_examples=5, deadline=None)
@given(end_ms=st.integers(1, 700), wanted=st.integers(1, 6))
def test_a_search_finds_the_last_time_and_goes_there(end_ms: int, wanted: int) -> None:
    search = THROWS._replace(begin={"wanted": wanted})
    with Rig(config_of(devices={"dice": {"kind": "rig_kinds:Counted", "links": {"wires": "wires"}}})) as rig:
        rig.answer("dice", "thrown", {"wanted": wanted})
        rig.run_until(end_ms * MS)
        at_ns = rig.answer("dice", "thrown", {"found": True})["at_ns"]
    counted = config_of(devices={"dice": {"kind": "rig_kinds:Counted", "links": {"wires": "wires"}}})
    with journey_of(counted) as travelled:
        run_to(travelled, end_ms * MS)
        found = asyncio.run(travelled.find(search))
        if at_ns == NEVER_NS:
            assert found["number"] == 0
            return
        assert (bool(found["number"]), found["at_ns"]) == (True, at_ns)
        assert travelled.now_ns == end_ms * MS
        asyncio.run(travelled.go_to(search))
        assert travelled.now_ns == at_ns
        assert travelled.answer("dice", "thrown", {"found": True})["is_there"]
        earlier = asyncio.run(travelled.find(search, at_ns - 1))
        assert earlier["number"] == 0 or earlier["at_ns"] < at_ns
        here = state_of_one(travelled)
        run_to(travelled, at_ns + 30 * MS)
        travelled.back(at_ns + MS)
        travelled.back(at_ns + MS)
        assert state_of_one(travelled)[1:] == here[1:]


@pytest.mark.parametrize(
    "search",
    [
        Search("dice", "rethrow", {"times": 1}, {"times": 1}),
        Search("dice", "thrown", {"wanted": 6}, {"found": True}),
        Search("nobody", "debug", {}, {}),
    ],
)
def test_a_question_that_searches_nothing_is_refused_and_changes_nothing(search: Search) -> None:
    with journey_of() as travelled:
        run_to(travelled, 120 * MS)
        before = state(travelled.rig)
        for find in (travelled.find, travelled.go_to):
            with pytest.raises(ControlError):
                asyncio.run(find(search))
        assert state(travelled.rig) == before
        run_to(travelled, 300 * MS)


def state_of_one(travelled: Journey) -> tuple[Any, ...]:
    return travelled.now_ns, travelled.rig.trace_hash(), travelled.rig.get("dice/throws")
