"""The outcome of scenarios for people, as JSON, and for CI."""

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.text import junit as form
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.scenarios.scenario_file import Scenario
from fieldrig_devices.scenarios.watching import Played

BEFORE_NS: Final = 50 * MS
"""The time in front of a violation whose changes are shown."""
MOST_TOLD: Final = 12


class Outcome(NamedTuple):
    """One scenario that was played."""

    file: Path
    scenario: Scenario
    played: Played
    wall_s: float

    @property
    def is_good(self) -> bool:
        return not self.played.violations

    @property
    def judged(self) -> list[str]:
        """The names of its properties, and of those of every rig that do not hold."""
        named = (one.name for one in self.scenario.properties)
        return list(dict.fromkeys((*named, *(one.property for one in self.played.violations))))


def lines_of(outcome: Outcome) -> Iterator[str]:
    """Yield a line for each property, and the reason of each that did not hold."""
    yield f"{outcome.file}  ({seconds(outcome.played.length_ns)})"
    broken = {one.property: one for one in outcome.played.violations}
    for name in outcome.judged:
        violation = broken.get(name)
        yield f"  {'ok    ' if violation is None else 'FAILED'}  {name}"
        if violation is not None:
            yield from (f"          {line}" for line in told(outcome.played, violation))


def told(played: Played, violation: Violation) -> list[str]:
    """Return the reason of a violation, the values, and the changes in the time in front of it."""
    values = ", ".join(f"{place} = {_shown(value)}" for place, value in violation.values)
    first = f"at {seconds(violation.at_ns)}: {violation.what}"
    begin_ns = violation.at_ns - BEFORE_NS
    changes = sorted(
        (at_ns, place, value)
        for place, track in played.tracks.items()
        for at_ns, value in track
        if begin_ns <= at_ns <= violation.at_ns
    )
    before = [f"  {seconds(at_ns)}: {place} = {_shown(value)}" for at_ns, place, value in changes[-MOST_TOLD:]]
    return [
        first,
        *([values] if values else []),
        *([f"in the {BEFORE_NS / MS:g} ms before:"] if before else []),
        *before,
    ]


def as_json(outcome: Outcome) -> dict[str, Any]:
    return {
        "file": str(outcome.file),
        "length_s": outcome.played.length_ns / S,
        "hash": outcome.played.hash,
        "properties": outcome.judged,
        "violations": [
            {**one._asdict(), "at_s": one.at_ns / S, "values": dict(one.values)} for one in outcome.played.violations
        ],
    }


def junit(outcomes: Sequence[Outcome]) -> bytes:
    """Return a report for CI with a test for each property."""
    return form.junit("fieldrig scenarios", {str(one.file): _cases(one) for one in outcomes})


def _cases(outcome: Outcome) -> list[form.Case]:
    broken = {one.property: one for one in outcome.played.violations}
    share_s = outcome.wall_s / len(outcome.judged)
    return [
        form.Case(
            name,
            share_s,
            [form.Failed(found.what, "\n".join(told(outcome.played, found)))] if (found := broken.get(name)) else [],
            file=str(outcome.file),
        )
        for name in outcome.judged
    ]


def _shown(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
