"""Two versions of a program on the same corpus: what got worse, and what is fixed."""

from typing import NamedTuple

from fieldrig_devices.search.corpus import Corpus
from fieldrig_devices.search.crew import Bench
from fieldrig_devices.search.piece import Piece
from fieldrig_devices.search.plan import Plan


class Changed(NamedTuple):
    """A property that holds in one of the two versions only."""

    property: str
    acts: tuple[str, ...]
    is_worse: bool

    def __str__(self) -> str:
        told = "no longer holds" if self.is_worse else "holds now"
        return f"{self.property} {told}: {'; '.join(self.acts) or 'without any action'}"


def compared(plan: Plan, corpus: Corpus) -> list[Changed]:
    """Play all runs of a corpus with the program as it is now."""
    changes = list[Changed]()
    with Bench(plan) as bench:
        for acts, _, length_ns, violations in corpus.runs():
            now = {one.property for one in bench.play(Piece(acts, 0, length_ns)).violations}
            before = {name for name, *_ in violations}
            shown = tuple(f"{act} at {act.at_ns / 1e6:g} ms" for act in acts)
            changes += [Changed(name, shown, name in now) for name in sorted(now ^ before)]
    return changes
