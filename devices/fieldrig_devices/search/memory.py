"""The outcomes of pieces that earlier searches have played, so that a search which goes on plays only what is new.

An outcome holds for one identity: the plan, and everything that its rig reads.  After any change of them, or of
fieldrig, all pieces are played again.
"""

from collections.abc import Iterable, Mapping
from hashlib import sha256
from importlib.resources import files
from pathlib import Path
from typing import Final, Protocol

from fieldrig.errors import ConfigError, RigError
from fieldrig_devices.search.outcome import Outcome, Record
from fieldrig_devices.search.piece import Piece, Run, acts_text
from fieldrig_devices.search.plan import Plan
from fieldrig_devices.search.rig_files import Luggage, luggage_of

PACKAGES: Final = ("fieldrig", "fieldrig_bus", "fieldrig_devices")


class Outcomes(Protocol):
    """The outcomes by the keys of their pieces."""

    def outcome(self, key: bytes) -> Outcome | None:
        """Return the outcome of a piece; None if it was not played."""


class Memory:
    """The outcomes that were there when the search began; those of this search are kept for the next one."""

    def __init__(self, store: Outcomes, identity: bytes | None) -> None:
        """Nothing is kept, and nothing is known, if `identity` is None."""
        self._store, self._identity = store, identity
        self._left: dict[bytes, int] = {}
        """How often each piece may still be recalled: as often as it was played, as dice throw some more than once."""
        self.known = 0
        """Pieces that were not played again."""

    def recall(self, piece: Piece, *, learns: bool) -> Outcome | None:
        """Return the outcome of a piece; `learns` is for a strategy that goes on from its states."""
        if self._identity is None:
            return None
        key = self._key(piece, learns)
        outcome = None if self._left.get(key) == 0 else self._store.outcome(key)
        left = self._left.setdefault(key, 0 if outcome is None else outcome.times)
        if left == 0 or outcome is None:
            return None
        self._left[key] = left - 1
        self.known += 1
        return outcome

    def record(self, piece: Piece, played: Run, shrunk: Iterable[str], *, learns: bool) -> Record | None:
        """Return what is to be kept of a piece that was played, after everything was done with it."""
        if self._identity is None:
            return None
        violations = tuple((one.property, one.at_ns, one.what) for one in played.violations)
        states, marks = (b"".join(sorted(played.states)), played.marks) if learns else (b"", b"")
        outcome = Outcome(violations, played.refused, tuple(shrunk), states, marks, played.way)
        return self._key(piece, learns), outcome

    def _key(self, piece: Piece, learns: bool) -> bytes:
        words = (acts_text(piece.acts), piece.from_ns, piece.until_ns, piece.is_whole, piece.world, learns)
        return sha256((self._identity or b"") + repr(words).encode()).digest()[:16]


def identity_of(plan: Plan, plan_file: Path, luggage: Luggage | None = None) -> bytes | None:
    """Return what is the same as long as all outcomes are; `luggage` is that of the plan, if it is known already.

    It is None for a plan whose master may depend on anything, and for a rig that cannot be loaded, which the search
    says with all mistakes.
    """
    if plan.scenario.master is not None:
        return None
    try:
        luggage = luggage or luggage_of(plan)
    except (ConfigError, RigError):
        return None
    content: Mapping[str, bytes] = {str(name): data for name, data in luggage.files.items()}
    digest = sha256(repr((sorted(content.items()), plan.scenario.overrides, luggage.paths["rig"])).encode())
    digest.update(plan_file.read_bytes())
    for package in PACKAGES:
        for file in sorted(Path(str(files(package))).rglob("*.py")):
            digest.update(file.read_bytes())  # and no dates, as another host may have played the corpus
    return digest.digest()
