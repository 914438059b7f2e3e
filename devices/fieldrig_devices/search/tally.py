"""A crew whose outcomes are counted on their way: the branches of programs that its pieces have passed."""

from collections.abc import Iterator, Sequence

from fieldrig.coverage.places import Place
from fieldrig_devices.search.crew import Crew
from fieldrig_devices.search.piece import Piece, Run


class Tally:
    def __init__(self, crew: Crew) -> None:
        self._crew = crew
        self._marks = 0
        """The marks that any piece has passed, as the bytes of a number."""

    def start(self, piece: Piece) -> None:
        self._crew.start(piece)

    def next(self) -> Run:
        played = self._crew.next()
        self._marks |= int.from_bytes(played.marks, "little")
        return played

    def drop(self, run: Run) -> None:
        self._crew.drop(run)

    def seen(self, places: Sequence[tuple[int, Place]]) -> Iterator[tuple[Place, bool]]:
        """Yield places, each with the number of its mark, with whether it was passed."""
        for number, place in places:
            yield place, bool(self._marks >> (8 * number) & 1)
