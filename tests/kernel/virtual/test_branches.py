"""Branches of a rig by fork: the same to the last bit, apart from each other, and gone with their rig."""

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from shipped import RIGS, in_virtual_time

from fieldrig import MS, ArgumentError, BranchMaker, MemoryStore, Rig, RigError, S, UnmetError, from_dict, virtual_time
from fieldrig.storage.store import FileStore
from fieldrig.virtual import may_branch
from fieldrig.virtual.branches import warm

pytestmark = [
    pytest.mark.system,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="this system has no fork"),
]
HERE = Path(__file__).parents[1]
NOISY: dict[str, Any] = {
    "time": "virtual",
    "buses": {
        "wires": {"kind": "wires.virtual"},
        "can0": {"kind": "can.virtual", "bitrate": 500_000, "faults": [{"what": "corrupt", "probability": 0.2}]},
    },
    "devices": {"dice": {"kind": "rig_kinds:Dice", "links": {"wires": "wires"}}},
}


def rig_of(**more: Any) -> Rig:
    return Rig(from_dict({**NOISY, **more}, HERE))


@pytest.fixture
def rig() -> Iterator[Rig]:
    """Dice that are thrown every 10 ms, at 25 ms."""
    with rig_of() as rig:
        rig.trace_hash()
        rig.run_until(25 * MS)
        yield rig


def throws(rig: Rig, more: int = 0) -> int:
    return int(rig.get("dice/throws")) + more


def fail(rig: Rig) -> None:
    raise LookupError(f"no luck at {rig.now_ns}")


def is_there(pid: int) -> bool:
    """True until a process has ended; a zombie has not been waited for."""
    return Path(f"/proc/{pid}").exists()


def descriptors() -> set[str]:
    """The open descriptors; that of the list itself has the same number each time."""
    return {entry.name for entry in Path("/proc/self/fd").iterdir()}


# ---- the same as the rig


@pytest.mark.long
@pytest.mark.parametrize("file", ["conveyor.yaml", "feeder.yaml", "lab.yaml", "arp-cell.yaml", "pam-machine.yaml"])
def test_child_parent_and_a_rig_that_was_never_branched_are_the_same(file: str) -> None:
    assert file in RIGS
    with Rig(in_virtual_time(file)) as straight:
        straight.trace_hash()
        straight.run_until(3 * S)
        expected = straight.trace_hash()
    with Rig(in_virtual_time(file)) as rig:
        rig.trace_hash()
        rig.run_until(2 * S)
        with rig.branch() as first:
            first.run_until(3 * S)
            with rig.branch() as second, second.branch() as third:
                third.run_for(S)
                found = first.trace_hash(), third.trace_hash()
        rig.run_until(3 * S)
        assert {*found, rig.trace_hash()} == {expected}
        assert int(expected.partition(":")[0]) > 0


def test_a_branch_goes_on_from_the_instant_of_its_rig_and_the_rig_stays(rig: Rig) -> None:
    with rig.branch() as branch:
        branch.run_for(30 * MS)
        assert (branch.now_ns, branch.get("dice/throws"), branch.next_ns()) == (55 * MS, 6, 60 * MS)
        assert branch.step() is True
        assert branch.now_ns == 60 * MS
        branch.set("dice/throws", 100)
        assert (rig.now_ns, throws(rig), branch.get("dice", "throws")) == (25 * MS, 3, 100)


def test_a_branch_has_the_calls_of_its_rig(rig: Rig) -> None:
    with rig.branch() as branch:
        assert branch.keys("dice") == rig.keys("dice")
        assert branch.facts("dice") == rig.facts("dice")
        assert branch.values("dice", ["throws"]) == branch.values("dice") == rig.values("dice")
        assert branch.front("dice") == rig.front("dice")
        assert branch.signals("wires") == rig.signals("wires")
        assert branch.statistics("can0") == rig.statistics("can0")
        assert branch.conditions("can0") == rig.conditions("can0")
        number = branch.add_fault("can0", {"what": "drop"})
        assert set(branch.faults("can0")) - set(rig.faults("can0")) == {number}
        branch.clear_fault("can0", number)
        assert branch.faults("can0") == rig.faults("can0")
        branch.restart("dice")
        assert branch.until(lambda: branch.get("dice/throws") == 6, within=S)
        with pytest.raises(UnmetError, match="dice/throws = 7"):
            branch.until(lambda: branch.get("dice/throws") == 9, within=11 * MS)


def test_a_function_runs_in_the_branch(rig: Rig) -> None:
    with rig.branch() as branch:
        assert branch.call(throws, more=7) == 10
        with pytest.raises(LookupError, match="no luck at 25000000") as wrong:
            branch.call(fail)
        assert "in fail" in str(wrong.value.__cause__)
        assert branch.call(throws) == 3


def test_an_answer_of_a_device_comes_out_of_a_branch(rig: Rig) -> None:
    with rig.branch() as branch:
        assert branch.answer("dice", "rethrow", {"times": 1}) == rig.answer("dice", "rethrow", {"times": 1})
        with pytest.raises(RigError, match="did you mean throws"):
            branch.get("dice/throw")


def has_points(rig: Rig) -> bool:
    node: Any = rig._engine.nodes["sensor"]
    return "_points" in vars(node.device)


@pytest.mark.long
def test_a_rig_that_is_warm_leaves_nothing_to_make_to_its_branches() -> None:
    with Rig(in_virtual_time("lab.yaml")) as rig, Rig(in_virtual_time("lab.yaml")) as cold:
        for each in (rig, cold):
            each.trace_hash()
            each.run_until(S)
        warm(rig)
        with rig.branch() as branch, cold.branch() as other:
            assert (branch.call(has_points), other.call(has_points)) == (True, False)
            branch.run_for(S)
            other.run_for(S)
            assert branch.trace_hash() == other.trace_hash()


def test_the_fixture_has_the_same_calls_where_there_is_no_fork(
    fieldrig_branch: BranchMaker, rig: Rig, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delattr(os, "fork")
    own = fieldrig_branch({**NOISY, "seed": 5}, boot=25 * MS)
    assert own.call(throws, more=7) == 10
    own.set("dice/throws", 100)
    assert (own.now_ns, own.get("dice/throws")) == (25 * MS, 100)
    again = fieldrig_branch({**NOISY, "seed": 5}, boot=25 * MS)
    assert again.get("dice/throws") == 3


# ---- random numbers


def test_random_numbers_go_on_unless_a_seed_is_given(rig: Rig) -> None:
    def thrown(seed: int | None) -> str:
        with rig.branch(seed) as branch:
            branch.run_for(200 * MS)
            return branch.trace_hash()

    assert thrown(None) == thrown(None)
    assert thrown(1) == thrown(1)
    assert len({thrown(None), thrown(1), thrown(2)}) == 3


def test_results_of_branches_are_in_the_order_of_their_seeds(rig: Rig) -> None:
    def scenario(rig: Rig, seed: int) -> tuple[int, str]:
        rig.run_for((10 - seed) * 20 * MS)
        return seed, rig.trace_hash()

    seeds = [3, 1, 2, 1]
    results = rig.branches(scenario, seeds, workers=3)
    assert [seed for seed, _ in results] == seeds
    assert results == rig.branches(scenario, seeds, workers=1)
    assert rig.now_ns == 25 * MS


def test_a_scenario_that_fails_is_told_with_its_seed(rig: Rig) -> None:
    def scenario(_rig: Rig, seed: int) -> int:
        if seed == 4:
            os.kill(os.getpid(), signal.SIGKILL)
        assert seed % 3, "a multiple of three"
        return seed

    with pytest.raises(RigError, match=r"failed with the seeds 3, 6\n.*a multiple of three"):
        rig.branches(scenario, [1, 3, 5, 6])
    with pytest.raises(RigError, match=r"failed with the seed 4\n  the process of the branch is gone"):
        rig.branches(scenario, [1, 4, 5])


# ---- apart from the rig


def test_a_branch_writes_nothing_of_its_rig(tmp_path: Path, rig: Rig) -> None:
    with (tmp_path / "log").open("w", encoding="utf-8") as log, (tmp_path / "log").open("rb") as reader:
        log.write("rig\n")
        log.flush()

        def write() -> None:
            log.write("instant\n")
            log.flush()

        rig.on_instant(write)
        with rig.branch() as branch:
            branch.run_for(50 * MS)
            assert branch.call(_read_all, reader.fileno()) == b"rig\n"
        assert (tmp_path / "log").read_text() == "rig\n"
        assert reader.read() == b"rig\n"
        rig.run_for(10 * MS)
        assert (tmp_path / "log").read_text() == "rig\ninstant\n"


def _read_all(_rig: Rig, number: int) -> bytes:
    return os.read(number, 100)


def test_the_memory_of_a_device_is_the_branch_s_own() -> None:
    store = MemoryStore(b"\x05")
    with Rig(from_dict(NOISY, HERE), stores={"dice": store}) as rig, rig.branch() as branch:
        before = store.load()
        assert branch.call(_save_new) == b"new"
        assert store.load() == before


def _save_new(rig: Rig) -> bytes | None:
    rig._stores["dice"].save(b"new")
    return rig._stores["dice"].load()


def test_nothing_is_left_of_a_branch(rig: Rig) -> None:
    before = descriptors()
    with rig.branch() as one, rig.branch(), one.branch() as nested:
        pids = one.pid, nested.pid
        assert all(map(is_there, pids))
    rig.branches(throws_of, range(4))
    assert descriptors() == before
    _wait_for_end(*pids)
    with pytest.raises(ChildProcessError):
        os.waitpid(one.pid, os.WNOHANG)
    one.close()
    with pytest.raises(RigError, match=r"the branch is closed\n  use it inside its `with` statement"):
        one.get("dice/throws")


def throws_of(rig: Rig, _seed: int) -> int:
    return throws(rig)


def _wait_for_end(*pids: int) -> None:
    while any(map(is_there, pids)):
        time.sleep(0.01)


def test_branches_end_with_their_rig() -> None:
    with rig_of() as rig:
        branch = rig.branch()
    assert not is_there(branch.pid)


def test_branches_end_with_the_process_of_their_rig_whatever_they_do() -> None:
    program = (
        "import os, signal\n"
        "from fieldrig import Rig, from_dict\n"
        "def forever(rig):\n"
        "    while True: pass\n"
        "rig = Rig(from_dict({'time': 'virtual'}))\n"
        "parked = rig.branch()\n"
        "busy = parked.branch()\n"
        "busy._pipe.send(('call', (forever, (), {})))\n"
        "print(parked.pid, busy.pid, flush=True)\n"
        "os.kill(os.getpid(), signal.SIGKILL)\n"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=False)
    assert done.returncode == -signal.SIGKILL, done.stderr
    for pid in map(int, done.stdout.split()):
        while is_there(pid) and "State:\tZ" not in Path(f"/proc/{pid}/status").read_text(encoding="utf-8"):
            time.sleep(0.01)


def test_a_branch_that_was_killed_says_so(rig: Rig) -> None:
    with rig.branch() as branch:
        os.kill(branch.pid, signal.SIGKILL)
        with pytest.raises(RigError, match=r"the process of the branch is gone\n  killed by SIGKILL"):
            branch.run_for(S)
    assert throws(rig) == 3


# ---- what cannot be branched


def test_processes_of_devices_cannot_be_branched() -> None:
    with rig_of(processes="each") as rig, pytest.raises(RigError, match=r'(?s)processes: each.*"processes=one"'):
        rig.branch()


def test_a_rig_with_younger_threads_cannot_be_branched(rig: Rig) -> None:
    go = threading.Event()
    thread = threading.Thread(target=go.wait, name="poller")
    thread.start()
    try:
        for wrong in (rig.branch, lambda: rig.branches(throws_of, [1]), lambda: rig.checkpoint_every(S)):
            with pytest.raises(RigError, match=r"(?s)threads run that are younger than it: poller.*before the rig is"):
                wrong()
        with rig_of() as younger, younger.branch() as branch:
            assert branch.call(throws) == 0 + throws(younger)
    finally:
        go.set()
        thread.join()
    rig.branch().close()


def test_a_rig_with_a_master_in_its_time_cannot_be_branched(rig: Rig) -> None:
    with virtual_time(rig), pytest.raises(RigError, match="threads run that are younger"):
        rig.branch()


def test_a_store_in_files_is_not_shared_with_a_branch(tmp_path: Path) -> None:
    config = from_dict(NOISY, HERE)
    with (
        Rig(config, stores={"dice": FileStore(tmp_path / "dice")}) as rig,
        pytest.raises(RigError, match=r"memory of dice, which is a FileStore\n  give the rig a MemoryStore"),
    ):
        rig.branch()


def test_the_middle_of_an_instant_cannot_be_branched_and_its_end_can(rig: Rig) -> None:
    def too_early(_bus: Any, _delivery: Any) -> None:
        rig.branch()

    rig.on_delivery(too_early)
    with pytest.raises(RigError, match=r"in the middle of an instant\n  a call of on_instant"):
        rig.run_for(10 * MS)
    with rig_of() as other:
        found = []

        def look() -> None:
            if other.is_branch:
                return
            with other.branch() as branch:
                branch.run_for(10 * MS)
                found.append(branch.get("dice/throws"))

        other.on_instant(look)
        other.run_until(20 * MS)
        assert found == [2, 3, 4]


def test_windows_is_told_that_it_has_no_fork(rig: Rig, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(may_branch, "HAS_FORK", False)
    with pytest.raises(RigError, match=r"this system cannot branch a rig\n.*Windows has not"):
        rig.branch()


def test_what_cannot_cross_the_pipe_is_refused(rig: Rig) -> None:
    with rig.branch() as branch:
        with pytest.raises(ArgumentError, match=r"call cannot send .*\n  expected functions of a module"):
            branch.call(lambda rig: rig.now_ns)
        with pytest.raises(ArgumentError, match="a result cannot leave the branch"):
            branch.call(_unsendable)
        with pytest.raises(ArgumentError, match="call cannot take 5"):
            branch.call(5)  # type: ignore[arg-type]
        assert branch.call(throws) == 3


def _unsendable(_rig: Rig) -> Any:
    return lambda: None
