"""Two versions of a program on the same corpus: what got worse, and what is fixed."""

from typing import NamedTuple

from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_devices.search import run
from fieldrig_devices.search.corpus import Corpus
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
    scenario, changes = plan.scenario, list[Changed]()
    with Rig(load(scenario.rig, ("time=virtual", *scenario.overrides))) as rig:
        rig.run_until(scenario.after_ns)
        for acts, _, length_ns, violations in corpus.runs():
            with rig.branch() as branch:
                now = {one.property for one in branch.call(run.play_all, scenario, acts, length_ns).violations}
            before = {name for name, *_ in violations}
            shown = tuple(f"{act} at {act.at_ns / 1e6:g} ms" for act in acts)
            changes += [Changed(name, shown, name in now) for name in sorted(now ^ before)]
    return changes
