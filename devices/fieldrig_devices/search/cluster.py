"""The workers of a Dask cluster as the crew of a search.

What speaks to the cluster has threads, so it is in a process of its own (`dask_client.py`): a rig here is branched.
"""

from importlib.util import find_spec
from types import TracebackType
from typing import Final, Self

from fieldrig.errors import UsageError
from fieldrig_devices.search.beside import Beside
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.rig_files import Luggage

MODULE: Final = "fieldrig_devices.search.dask_client"


class ClusterCrew:
    def __init__(self, address: str, luggage: Luggage) -> None:
        """`address` is that of the scheduler, such as `tcp://10.0.0.1:8786`.

        RigError if none answers there; UsageError if Dask is not installed.
        """
        if find_spec("distributed") is None:
            raise UsageError("there is no dask.distributed", "install it: pip install fieldrig[dask]")
        self._client = Beside(MODULE, (address, luggage))

    def start(self, piece: Piece) -> None:
        self._client.ask(piece)

    def next(self) -> Run:
        """Wait for the next outcome.  RigError if workers are lost again and again with the same piece."""
        played: Run = self._client.ask(None)
        return played

    def drop(self, run: Run) -> None:
        """Nothing: a worker lets go by itself of what it has not gone on from for long."""

    def close(self) -> None:
        """End what still runs."""
        self._client.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self.close()
