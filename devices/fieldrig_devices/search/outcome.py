"""The outcome of a piece as a corpus keeps it."""

import zlib
from typing import Final, NamedTuple

from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.search.piece import Piece, Run

LONGEST: Final = 1 << 22
"""Bytes of the marks of a run, in a file that may come from elsewhere."""
STATE_SIZE: Final = 8
"""Bytes of the digest of a state."""


class Outcome(NamedTuple):
    """The outcome of a piece as it is kept, and what was done with it."""

    violations: tuple[tuple[str, int, str], ...]
    refused: str
    shrunk: tuple[str, ...]
    """The properties for which the run was made small."""
    states: bytes
    """The digests of the states, one behind the other; nothing for a strategy that learns nothing from them."""
    marks: bytes
    way: bytes
    times: int = 1
    """How often the piece was played."""

    def run(self, piece: Piece) -> Run:
        """Return the run of this piece again."""
        violations = tuple(Violation(*one, ()) for one in self.violations)
        size = STATE_SIZE
        states = frozenset(self.states[at : at + size] for at in range(0, len(self.states), size))
        return Run(piece.acts, violations, piece.until_ns, states, piece.world, self.marks, self.way, 0.0, self.refused)


Record = tuple[bytes, Outcome]
"""An outcome with the key of its piece."""


def packed(data: bytes) -> bytes:
    """Return bytes as they are kept."""
    return zlib.compress(data) if data else b""


def unpacked(data: bytes) -> bytes:
    """Return bytes that were packed.  ValueError for others."""
    try:
        return zlib.decompressobj().decompress(data, LONGEST) if data else b""
    except (TypeError, zlib.error) as cause:
        raise ValueError(f"expected packed bytes: {cause}") from cause
