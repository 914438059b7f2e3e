"""The adapter to Dask, and the only file that knows `dask.distributed`: a process of its own beside a search.

Each worker gets the plan with the files of its rig when the search begins, or when it joins later.  It plays pieces in
helpers with one thread (`helper.py`), because a worker has many, and a fork of it would not be safe.  A piece whose
worker is lost is played by another one; Dask sees to it.
"""

from collections import deque
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


def play(name: str, piece: Piece) -> Run:
    """Play a piece; this is what a worker is asked for."""
    helpers: Helpers = get_worker().plugins[name]
    return helpers.play(piece)


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
        self._open: deque[Future] = deque()

    def __call__(self, piece: Piece | None) -> Run | None:
        if piece is not None:
            self._open.append(self._client.submit(play, self._name, piece, pure=False))
            return None
        future = self._open.popleft()
        try:
            played: Run = future.result()
        except KilledWorker as cause:
            raise RigError("workers are lost with a piece again and again", str(cause)) from cause
        finally:
            future.release()
        return played

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
