"""Checkpoints of a rig, and going back to any instant of its past."""

import os
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from shipped import in_virtual_time

from fieldrig import MS, ArgumentError, BranchMaker, Rig, RigError, S, from_dict
from fieldrig.clock import US

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
]
HERE = Path(__file__).parents[1]
RIG: dict[str, Any] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}},
        "slow": {"kind": "rig_kinds:Dice", "period_ms": 35, "links": {"wires": "wires"}},
    },
}


def rig_of() -> Rig:
    rig = Rig(from_dict(RIG, HERE))
    rig.trace_hash()
    return rig


# ---- random programs

Step = tuple[str, int]
STEPS = st.tuples(
    st.sampled_from(["run", "run", "set", "rethrow", "loaded", "clear", "restart", "step", "refused"]),
    st.integers(0, 60),
)


def act(rig: Rig, step: Step) -> None:
    what, number = step
    match what:
        case "run":
            rig.run_for(number * MS)
        case "step":
            rig.step()
        case "set":
            rig.set("dice/throws", number)
        case "rethrow":
            rig.answer("slow", "rethrow", {"times": number})
        case "loaded":
            rig.add_fault("dice", {"what": "loaded", "duration_ms": 1 + number})
        case "clear":
            for fault in rig.faults("dice"):
                rig.clear_fault("dice", fault)
        case "restart":
            rig.restart("slow")
        case _:
            with pytest.raises(RigError):
                rig.set("dice/throws", -1)


def state(rig: Any) -> tuple[Any, ...]:
    return rig.now_ns, rig.trace_hash(), rig.get("dice/throws"), rig.get("slow/throws")


@settings(max_examples=15)
@example(steps=[("run", 25), ("set", 40), ("run", 30)], period_ms=100, keep=2, targets=[0.9], later_ms=20)
@example(steps=[("run", 25), ("loaded", 9), ("set", 4), ("run", 60)], period_ms=30, keep=2, targets=[0.8], later_ms=9)
@given(
    steps=st.lists(STEPS, min_size=1, max_size=12),
    period_ms=st.integers(1, 100),
    keep=st.integers(2, 6),
    targets=st.lists(st.floats(0, 1), min_size=1, max_size=3),
    later_ms=st.integers(0, 50),
)
def test_the_past_of_any_rig_is_as_it_was(
    steps: list[Step], period_ms: int, keep: int, targets: list[float], later_ms: int
) -> None:
    with rig_of() as rig, rig_of() as straight:
        rig.checkpoint_every(period_ms * MS, keep=keep)
        for step in steps:
            act(rig, step)
            act(straight, step)
        assert state(rig) == state(straight)
        for target in targets:
            ns = round(target * rig.now_ns)
            with rig.back(ns) as past, replayed(steps, ns) as expected:
                assert state(past) == state(expected)
                past.run_for(later_ms * MS)
                expected.run_for(later_ms * MS)
                assert state(past) == state(expected)


def replayed(steps: list[Step], ns: int) -> Rig:
    """Return a rig that was never branched, with these steps, as its clock came to `ns`."""
    rig = rig_of()
    for what, number in steps:
        if what == "run" and rig.now_ns + number * MS >= ns:
            break
        next_ns = rig.next_ns()
        if what == "step" and next_ns is not None and next_ns >= ns:
            break
        if rig.now_ns >= ns:
            break
        act(rig, (what, number))
    rig.run_until(ns)
    return rig


# ---- shipped rigs


@pytest.mark.long
def test_the_conveyor_goes_back_to_any_instant() -> None:
    instants = [1_234_567 * US, 1_500 * MS, 1_999 * MS]
    hashes = []
    with Rig(in_virtual_time("conveyor.yaml")) as straight:
        straight.trace_hash()
        straight.set("panel", "6200:01", 3)
        for ns in instants:
            straight.run_until(ns)
            hashes.append(straight.trace_hash())
    with Rig(in_virtual_time("conveyor.yaml")) as rig:
        rig.trace_hash()
        rig.checkpoint_every(250 * MS, keep=4)
        rig.set("panel", "6200:01", 3)
        rig.run_until(2 * S)
        for ns, expected in reversed(list(zip(instants, hashes, strict=True))):
            with rig.back(ns) as past:
                assert (past.now_ns, past.trace_hash()) == (ns, expected)
        assert all(private > 0 for private in rig.checkpoints().values())
        assert len(rig.checkpoints()) == 4


# ---- checkpoints


def test_checkpoints_get_rarer_with_their_age() -> None:
    with rig_of() as rig:
        rig.checkpoint_every(10 * MS, keep=8)
        rig.run_until(400 * MS)
        kept = list(rig.checkpoints())
        gaps = [after - before for before, after in pairwise(kept)]
        assert (len(kept), kept[0], kept[-1]) == (8, 0, 400 * MS)
        assert gaps[-1] == 10 * MS
        assert max(gaps[:3]) >= 5 * max(gaps[-2:])


def test_the_past_can_take_another_course() -> None:
    with rig_of() as rig:
        rig.checkpoint_every(50 * MS)
        rig.run_until(100 * MS)
        rig.set("dice/throws", 1000)
        rig.run_until(200 * MS)
        with rig.back(100 * MS) as past:
            assert past.get("dice/throws") == 11  # what was set at this instant has not been set yet
            past.run_until(200 * MS)
            assert past.get("dice/throws") == 21
        assert rig.get("dice/throws") == 1010


def test_what_cannot_be_repeated_has_a_checkpoint_of_its_own() -> None:
    with rig_of() as rig:
        rig.checkpoint_every(S, keep=2)
        rig.run_until(33 * MS)
        rig.on_change("slow/throws", lambda value: rig.set("dice/throws", int(value) * 100))
        rig.run_until(90 * MS)
        expected = state(rig)
        rig.run_until(5 * S)
        with rig.back(90 * MS) as past:
            assert state(past) == expected
        with rig.back(20 * MS) as past:
            past.run_until(60 * MS)
            assert past.get("dice/throws") == 7


def descriptors() -> set[str]:
    return {entry.name for entry in Path("/proc/self/fd").iterdir()}


def test_one_instant_has_one_checkpoint() -> None:
    with rig_of() as rig:
        rig.checkpoint_every(S)
        before = len(descriptors())
        recording = rig.record(["dice/throws", "slow/throws"], "change")
        rig.run_until(20 * MS)
        recording.end()
        assert len(descriptors()) == before


def test_checkpoints_end() -> None:
    before = descriptors()
    with rig_of() as rig:
        end = rig.checkpoint_every(10 * MS)
        rig.run_until(50 * MS)
        assert list(rig.checkpoints()) == [0, 10 * MS, 20 * MS, 30 * MS, 40 * MS, 50 * MS]
        end()
        rig.run_until(90 * MS)
        assert rig.checkpoints() == {}
        with pytest.raises(RigError, match="no checkpoints to go back to"):
            rig.back(20 * MS)
        rig.checkpoint_every(10 * MS)
        with pytest.raises(RigError, match=r"cannot go back to 0.02 s\n  its first checkpoint is at 0.09 s"):
            rig.back(20 * MS)
        with pytest.raises(ArgumentError, match=r"cannot go back to 1 s: it is at 0.09 s"):
            rig.back(S)
    assert descriptors() == before


def test_members_from_outside_and_checkpoints_exclude_each_other() -> None:
    with rig_of() as rig:
        rig.attach("bench")
        with pytest.raises(RigError, match=r"members from outside has no checkpoints: bench\n  what a member sends"):
            rig.checkpoint_every(S)
        rig.detach("bench")
        rig.checkpoint_every(S)
        with pytest.raises(RigError, match="a rig with checkpoints takes no members from outside"):
            rig.attach("bench")


# ---- the fixture


@pytest.mark.parametrize("more", [1, 2])
def test_each_test_has_a_branch_of_a_rig_that_was_booted_once(fieldrig_branch: BranchMaker, more: int) -> None:
    file = str(HERE.parents[1] / "configs/lab.yaml")
    branch = fieldrig_branch(file, boot=100 * MS)
    assert (branch.now_ns, branch.get("tank/level")) == (100 * MS, 0.5)
    branch.set("tank/level", 1.0 + more / 10)
    branch.run_for(more * MS)
    pids = {branch.call(parent), fieldrig_branch(file, boot=100 * MS).call(parent)}
    assert pids == {os.getpid()}


def test_a_rig_boots_by_a_function(fieldrig_branch: BranchMaker) -> None:
    rig = {**RIG, "buses": RIG["buses"], "devices": {}}
    assert fieldrig_branch(rig, boot=to_a_second).now_ns == S
    assert fieldrig_branch(rig).now_ns == 0


def parent(_rig: Rig) -> int:
    return os.getppid()


def to_a_second(rig: Rig) -> None:
    rig.run_until(S)
