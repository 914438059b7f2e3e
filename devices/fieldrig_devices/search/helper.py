"""A bench in a process of its own that has one thread, so that it can branch wherever it was started."""

from pathlib import Path
from tempfile import TemporaryDirectory
from types import TracebackType
from typing import Final, Self

from fieldrig_devices.search.bench import Bench
from fieldrig_devices.search.beside import Beside, serve
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.rig_files import Luggage

MODULE: Final = "fieldrig_devices.search.helper"


class Helper:
    """The end in the process that has started it."""

    def __init__(self, luggage: Luggage) -> None:
        """RigError or ConfigError for a rig that cannot be loaded there."""
        self._beside = Beside(MODULE, luggage)

    def play(self, piece: Piece) -> Run:
        """Play a piece.  What the rig raises is raised here."""
        played: Run = self._beside.ask(piece)
        return played

    def close(self) -> None:
        self._beside.close()


class _Unpacked:
    """A bench with the files of its rig in a folder of its own."""

    def __init__(self, luggage: Luggage) -> None:
        self._folder = TemporaryDirectory(prefix="search")
        self._bench = Bench(luggage.unpack(Path(self._folder.name)))

    def __call__(self, piece: Piece) -> Run:
        return self._bench.play(piece)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, fault: BaseException | None, tb: TracebackType | None) -> None:
        self._bench.close()
        self._folder.cleanup()


if __name__ == "__main__":
    serve(_Unpacked)
