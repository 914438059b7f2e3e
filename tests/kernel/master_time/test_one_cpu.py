"""The threads of a master on one processor, and how they leave it when others want it."""

import os
import sys
import threading
from typing import Any

import pytest

from fieldrig import Rig, from_dict, virtual_time
from fieldrig.master_time import one_cpu
from fieldrig.master_time.one_cpu import OneCpu

NOTHING: Any = {"time": "virtual", "buses": {}, "devices": {}}
HAS_CHOICE = hasattr(os, "sched_getaffinity") and len(os.sched_getaffinity(0)) > 1
needs_choice = pytest.mark.skipif(not HAS_CHOICE, reason="this host has no choice of processors")


pytestmark = pytest.mark.skipif(sys.platform != "linux", reason="threads are bound on Linux only")


class Host:
    """A host with some processors, whose time and load are set by hand."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch, cpus: set[int]) -> None:
        self.bound: dict[int, set[int]] = {}
        self.now_s = self.spent_s = 0.0
        monkeypatch.setattr(os, "sched_getaffinity", lambda native: cpus, raising=False)
        monkeypatch.setattr(os, "sched_setaffinity", self._bind, raising=False)
        monkeypatch.setattr(one_cpu, "_real_monotonic", lambda: self.now_s)
        monkeypatch.setattr(one_cpu, "_real_process_time", lambda: self.spent_s)

    def _bind(self, native: int, cpus: list[int]) -> None:
        if native == GONE:
            raise ProcessLookupError
        self.bound[native] = set(cpus)

    def work(self, seconds: float, share: float) -> None:
        self.now_s += seconds
        self.spent_s += seconds * share


GONE = 99


def test_threads_are_on_one_processor_and_go_on_together_when_others_want_it(monkeypatch: pytest.MonkeyPatch) -> None:
    host = Host(monkeypatch, {2, 4, 7})
    held = OneCpu()
    for native in (11, 12, GONE):
        held.take(native)
    (first,) = host.bound[11]
    assert host.bound[12] == {first}
    host.work(0.25, share=0.95)
    held.look()
    assert host.bound == {11: {first}, 12: {first}}
    seen = [first]
    for _ in range(3):
        host.work(0.25, share=0.5)
        held.look()
        assert host.bound[11] == host.bound[12]
        seen += host.bound[11]
    assert sorted(seen[:3]) == [2, 4, 7]
    assert seen[3] == first
    held.forget(12)
    held.close()
    assert host.bound[11] == {2, 4, 7}
    assert host.bound[12] == {first}, "another thread may have its number by now"


@pytest.mark.parametrize("cpus", [{3}, set[int]()])
def test_without_a_choice_nothing_is_bound(monkeypatch: pytest.MonkeyPatch, cpus: set[int]) -> None:
    host = Host(monkeypatch, cpus)
    held = OneCpu()
    held.take(11)
    host.work(1.0, share=0.0)
    held.look()
    held.close()
    assert not host.bound


@needs_choice
def test_a_block_binds_its_members_and_no_other_thread() -> None:
    before, seen, over = os.sched_getaffinity(0), list[set[int]](), threading.Event()
    outside = threading.Thread(target=over.wait)
    outside.start()
    with Rig(from_dict(NOTHING)) as rig, virtual_time(rig):
        member = threading.Thread(target=lambda: seen.append(os.sched_getaffinity(0)))
        member.start()
        member.join()
        seen.append(os.sched_getaffinity(0))
        assert outside.native_id is not None
        assert os.sched_getaffinity(outside.native_id) == before
    over.set()
    outside.join()
    assert [len(cpus) for cpus in seen] == [1, 1]
    assert os.sched_getaffinity(0) == before


@needs_choice
def test_a_block_that_fails_leaves_the_processors_as_they_were() -> None:
    before = os.sched_getaffinity(0)
    with pytest.raises(RuntimeError), Rig(from_dict(NOTHING)) as rig, virtual_time(rig):
        raise RuntimeError
    assert os.sched_getaffinity(0) == before
