"""The notes of several processes about the programs that they run, also of a process that was killed."""

import os
import signal
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from fieldrig.coverage import collecting
from fieldrig.coverage.collecting import Collector
from fieldrig.coverage.places import Kind, Marked, Place

PLACES = [Place("a.st", "Main", Kind.STATEMENT, line, 1) for line in (1, 2, 3)]


def program() -> Marked:
    return Marked([*enumerate(PLACES)], [0, 0, 0])


def run(collector: Collector) -> list[int]:
    """Return the lines that have run."""
    return sorted(place.line for place, has_run in collector.news() if has_run)


def forked(work: Callable[[], None], *, is_killed: bool = False) -> None:
    """Run `work` in a copy of this process, and wait for its end."""
    assert sys.platform != "win32"
    pid = os.fork()
    if pid == 0:
        work()
        os.kill(os.getpid(), signal.SIGKILL) if is_killed else os._exit(0)
    os.waitpid(pid, 0)


def test_nothing_is_noted_without_a_context() -> None:
    marked = program()
    collecting.use(marked)
    collecting.flush()
    assert (collecting.is_on(), collecting.news()) == (False, ())
    with collecting.collecting() as collector:
        assert collecting.is_on()
        assert collector.news() == ()


def test_a_program_begins_with_nothing_run() -> None:
    marked = program()
    marked.hits[0] = 1
    with collecting.collecting() as collector:
        collecting.use(marked)
        assert len(collector.news()) == 3
        assert run(collector) == []
        marked.hits[2] = 1
        assert run(collector) == [3]


def test_a_block_within_another_counts_in_both() -> None:
    outer, inner = program(), program()
    with collecting.collecting() as around:
        collecting.use(outer)
        outer.hits[0] = 1
        with collecting.collecting() as within:
            collecting.use(inner)
            inner.hits[1] = 1
            assert run(within) == [2]
        assert run(around) == [1, 2]


def test_a_program_that_is_loaded_again_in_a_block_within_another_counts_in_both() -> None:
    marked = program()
    with collecting.collecting() as around:
        collecting.use(marked)
        marked.hits[0] = 1
        with collecting.collecting() as within:
            collecting.use(marked)
            marked.hits[1] = 1
            assert run(within) == [2]
        collecting.use(marked)
        marked.hits[2] = 1
        assert sorted(set(run(around))) == [1, 2, 3]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
def test_forked_processes_count_what_they_have_noted() -> None:
    marked = program()

    def step(line: int, is_noted: bool) -> None:
        marked.hits[line - 1] = 1
        if is_noted:
            collecting.flush()

    with collecting.collecting() as collector:
        collecting.use(marked)
        marked.hits[0] = 1
        forked(lambda: step(2, True), is_killed=True)
        forked(lambda: step(3, False), is_killed=True)
        assert run(collector) == [1, 2]


@pytest.mark.skipif(not hasattr(os, "fork"), reason="Windows has no fork")
def test_a_program_that_only_a_forked_process_loads_counts() -> None:
    def load() -> None:
        marked = program()
        collecting.use(marked)
        marked.hits[1] = 1
        collecting.flush()

    with collecting.collecting() as collector:
        load()
        forked(load)
        assert run(collector) == [2, 2]


def test_a_process_with_the_number_of_one_before_keeps_what_that_one_noted(monkeypatch: pytest.MonkeyPatch) -> None:
    marked = program()
    with collecting.collecting() as collector:
        collecting.use(marked)
        for line, number in ((1, 500), (2, 501), (3, 500)):
            monkeypatch.setattr(os, "getpid", lambda number=number: number)
            marked.hits[:] = [int(line == one) for one in (1, 2, 3)]
            collecting.flush()
        assert run(collector) == [1, 2, 3]


def test_a_folder_that_is_gone_is_no_fault_of_the_program(tmp_path: Path) -> None:
    marked = program()
    collector = Collector(tmp_path / "gone")
    collector.use(program())
    (tmp_path / "gone").mkdir()
    collector.use(marked)
    for file in (tmp_path / "gone").iterdir():
        file.unlink()
    (tmp_path / "gone").rmdir()
    marked.hits[0] = 1
    collector.flush()
    assert collector.news() == ()
