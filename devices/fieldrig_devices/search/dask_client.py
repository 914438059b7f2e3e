"""The adapter to Dask, and the only file that knows `dask.distributed`: a process of its own beside a search.

Each worker gets the plan with the files of its rig when the search begins, or when it joins later.  It plays pieces in
helpers with one thread (`helper.py`), because a worker has many, and a fork of it would not be safe.  A piece whose
worker is lost is played by another one; Dask sees to it.

A task of Dask costs some 40 ms besides, so that short pieces travel together.
"""

from collections import deque
from collections.abc import Sequence
from functools import partial
from importlib.metadata import version
from queue import Empty, SimpleQueue
from types import TracebackType
from typing import Any, Final, Self
from uuid import uuid4

from distributed import Client, Future, KilledWorker, WorkerPlugin, get_worker

from fieldrig.errors import RigError
from fieldrig_devices.search.beside import serve
from fieldrig_devices.search.helper import Helper
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.rig_files import Luggage

PACKAGE: Final = "fieldrig"
CONNECT_S: Final = 10
"""Longest time to find the scheduler."""
TASK_S: Final = 0.5
"""The work that a task should have, by the processor time of the pieces before."""
AHEAD: Final = 2
"""Tasks for each thread of a worker: one that it plays, and one that is there when it has ended."""


class Helpers(WorkerPlugin):  # type: ignore[misc]  # distributed has no types
    """The helpers of one worker: one for each of its threads that plays a piece."""

    def __init__(self, name: str, luggage: Luggage, wanted: str) -> None:
        self.name, self._luggage, self._version = name, luggage, wanted

    def setup(self, worker: Any) -> None:
        if (own := version(PACKAGE)) != self._version:
            raise RigError(
                f"a worker has fieldrig {own}, and the search {self._version}", "install the same everywhere"
            )
        self._idle: SimpleQueue[Helper] = SimpleQueue()
        self._all: list[Helper] = []

    def teardown(self, worker: Any) -> None:
        for helper in self._all:
            helper.close()

    def play(self, piece: Piece) -> Run:
        try:
            helper = self._idle.get_nowait()
        except Empty:
            helper = Helper(self._luggage)
            self._all.append(helper)
        played = helper.play(piece)
        self._idle.put(helper)
        return played


def play(name: str, pieces: Sequence[Piece]) -> list[Run | Exception]:
    """Play pieces, as a worker is asked to, up to the first that raises; what it raises is its outcome."""
    helpers: Helpers = get_worker().plugins[name]
    outcomes: list[Run | Exception] = []
    for piece in pieces:
        try:
            outcomes.append(helpers.play(piece))
        except Exception as fault:  # noqa: BLE001  it is raised where the piece came from
            return [*outcomes, fault]
    return outcomes


class Asked:
    """Starts the pieces that it is given, and waits for the first of them for None."""

    def __init__(self, where: tuple[str, Luggage]) -> None:
        address, luggage = where
        self._name = f"fieldrig-{uuid4()}"
        try:
            self._client = Client(address, timeout=CONNECT_S, set_as_default=False)
        except (OSError, ValueError) as cause:
            raise RigError(f"no scheduler of Dask answers at {address}: {cause}", "start `dask scheduler`") from cause
        self._client.register_plugin(Helpers(self._name, luggage, version(PACKAGE)))
        self._waiting: deque[tuple[int, Piece]] = deque()
        self._over: SimpleQueue[tuple[Sequence[int], Future]] = SimpleQueue()
        """The tasks that have ended, with the numbers of their pieces; a thread of Dask puts them here."""
        self._ended: dict[int, Run | Exception] = {}
        self._tasks = self._started = self._returned = 0
        self._busy_s, self._played = 0.0, 0
        self._threads = self._count_threads()

    def __call__(self, piece: Piece | None) -> Run | None:
        if piece is not None:
            self._waiting.append((self._started, piece))
            self._started += 1
            while not self._over.empty():
                self._take(*self._over.get())
            self._send()
            return None
        while self._returned not in self._ended:
            self._take(*self._over.get())
            self._send()
        outcome = self._ended.pop(self._returned)
        self._returned += 1
        if isinstance(outcome, KilledWorker):
            raise RigError("workers are lost with a piece again and again", str(outcome)) from outcome
        if isinstance(outcome, Exception):
            raise outcome
        return outcome

    def _send(self) -> None:
        """Start tasks for the pieces that wait, up to some for each worker."""
        while self._waiting and self._tasks < AHEAD * self._threads:
            most = min(self._most_together(), -(-len(self._waiting) // self._threads))
            numbers, pieces = zip(*(self._waiting.popleft() for _ in range(most)), strict=True)
            task = self._client.submit(play, self._name, pieces, pure=False)
            self._tasks += 1
            task.add_done_callback(partial(self._note, numbers))

    def _note(self, numbers: Sequence[int], task: Future) -> None:
        self._over.put((numbers, task))

    def _most_together(self) -> int:
        """Return how many pieces are as much work as a task should have; one before the first has ended."""
        return max(int(TASK_S * self._played / self._busy_s), 1) if self._busy_s else 1

    def _take(self, numbers: Sequence[int], task: Future) -> None:
        """Take the outcomes of a task that has ended."""
        try:
            outcomes: list[Run | Exception] = task.result()
        except Exception as fault:  # noqa: BLE001  it is raised in the search, in its turn
            outcomes = [fault]
        for number, outcome in zip(numbers, outcomes, strict=False):
            self._ended[number] = outcome
            if isinstance(outcome, Run):
                self._busy_s, self._played = self._busy_s + outcome.cpu_s, self._played + 1
        self._tasks -= 1
        self._threads = self._count_threads()

    def _count_threads(self) -> int:
        """Return the threads of all workers; 1 while there is none, as one may join later."""
        threads: dict[str, int] = self._client.nthreads()
        return max(sum(threads.values()), 1)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self._client.unregister_worker_plugin(self._name)
        self._client.close()


def main() -> None:
    """Serve the search; by the name of this module, so that workers find what they are sent."""
    from fieldrig_devices.search import dask_client

    serve(dask_client.Asked)


if __name__ == "__main__":
    main()
