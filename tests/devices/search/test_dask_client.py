"""The pieces of a search as tasks of Dask: short ones travel together, and outcomes come in the order of the pieces."""

from collections.abc import Callable, Sequence
from types import SimpleNamespace
from typing import Any, cast

import pytest

from fieldrig.errors import RigError
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.rig_files import Luggage

dask_client = pytest.importorskip("fieldrig_devices.search.dask_client", reason="pip install distributed")

THREADS = 2


class HandTask:
    """A task that ends when the test says so."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = pieces
        self.outcome: Any = None
        self._call: Callable[[Any], None] = lambda _task: None

    def result(self) -> Any:
        if isinstance(self.outcome, Exception):
            raise self.outcome
        return self.outcome

    def add_done_callback(self, call: Callable[[Any], None]) -> None:
        self._call = call

    def end(self, outcome: Any) -> None:
        self.outcome = outcome
        self._call(self)

    def play(self, cpu_s: float) -> None:
        """Let each piece have run for this time."""
        self.end([Run((), (), piece.until_ns, cpu_s=cpu_s) for piece in self.pieces])


class HandClient:
    """A connection to a cluster of two workers with one thread each."""

    def __init__(self, _address: str, **_options: Any) -> None:
        self.tasks: list[HandTask] = []

    def register_plugin(self, _plugin: Any) -> None:
        """Have no workers that could use it."""

    def nthreads(self) -> dict[str, int]:
        return {"one": 1, "two": 1}

    def submit(self, _play: Any, _name: str, pieces: Sequence[Piece], *, pure: bool) -> HandTask:
        assert not pure
        self.tasks.append(HandTask(pieces))
        return self.tasks[-1]


class Bench:
    def __init__(self) -> None:
        self.asked = dask_client.Asked(("tcp://127.0.0.1:1", cast(Luggage, None)))
        self.tasks: list[HandTask] = self.asked._client.tasks

    def start(self, *lengths_ns: int) -> None:
        for length_ns in lengths_ns:
            assert self.asked(Piece((), 0, length_ns)) is None

    def lengths(self, count: int) -> list[int]:
        """Return the lengths of the next pieces whose outcomes come."""
        return [self.asked(None).length_ns for _ in range(count)]

    @property
    def sizes(self) -> list[int]:
        return [len(task.pieces) for task in self.tasks]


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch) -> Bench:
    monkeypatch.setattr(dask_client, "Client", HandClient)
    return Bench()


def test_short_pieces_travel_together_and_come_in_their_order(bench: Bench) -> None:
    bench.start(*range(20))
    assert bench.sizes == [1] * dask_client.AHEAD * THREADS
    bench.tasks[1].play(0.01)
    bench.start(20)
    assert bench.sizes == [1, 1, 1, 1, 9]
    bench.tasks[4].play(0.01)
    bench.tasks[0].play(0.01)
    assert bench.lengths(2) == [0, 1]
    assert bench.sizes[5:] == [4, 2]
    for number in (2, 3, 5, 6):
        bench.tasks[number].play(0.01)
    assert bench.lengths(15) == [*range(2, 17)]
    assert bench.sizes[7:] == [1, 1]
    for number in (7, 8):
        bench.tasks[number].play(0.01)
    assert bench.lengths(4) == [*range(17, 21)]


def test_pieces_that_are_enough_work_travel_alone(bench: Bench) -> None:
    bench.start(*range(10))
    for number in range(10):
        bench.tasks[number].play(2 * dask_client.TASK_S)
        assert bench.lengths(1) == [number]
    assert bench.sizes == [1] * 10


def test_what_a_piece_raises_comes_in_its_turn(bench: Bench) -> None:
    bench.start(1, 2, 3, 4, 5, 6)
    bench.tasks[0].play(0.01)
    bench.tasks[1].end([RigError("the rig cannot be loaded", "")])
    assert bench.lengths(1) == [1]
    with pytest.raises(RigError, match="cannot be loaded"):
        bench.asked(None)


def test_pieces_that_kill_their_workers_end_the_search(bench: Bench) -> None:
    bench.start(1)
    bench.tasks[0].end(dask_client.KilledWorker("a task", SimpleNamespace(address="tcp://10.0.0.2:1"), 3))
    with pytest.raises(RigError, match="workers are lost with a piece again and again"):
        bench.asked(None)
