"""The outcome of scenarios for people, as JSON, and for CI."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.text import junit as form
from fieldrig.virtual.readings import seconds
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.scenarios.scenario_file import Scenario
from fieldrig_devices.scenarios.watching import Played, Track

BEFORE_NS: Final = 50 * MS
"""The time in front of a violation whose changes are shown."""
NOT_JUDGED: Final = "it could not be judged, because a fault or a step was left in the end"
SEES_ALL: Final = "the scenario sees all messages"
"""The property of every scenario in real time."""
MOST_TOLD: Final = 12
MOST_OF_PLACE: Final = 3
"""Changes of one place that are shown: a level changes all the time."""


class Outcome(NamedTuple):
    """One scenario that was played."""

    file: Path
    """Its file; the place in a test for a scenario of Python."""
    scenario: Scenario
    played: Played
    wall_s: float

    @property
    def is_good(self) -> bool:
        """True if all properties hold, and every step has come."""
        return not failures(self)

    @property
    def judged(self) -> list[str]:
        """The names of its properties, of those of every rig that do not hold, and of steps that have not come."""
        named = (one.name for one in self.scenario.properties)
        return list(dict.fromkeys((*named, *(name for name, _ in failures(self)))))

    @property
    def violations(self) -> tuple[Violation, ...]:
        """The violations, in the order in which they were seen."""
        return self.played.violations

    @property
    def tracks(self) -> Mapping[str, Track]:
        """The changes of all places that it reads or writes: instants from its begin, and values."""
        return self.played.tracks

    def write_picture(self, file: str | Path) -> None:
        """Write the picture of its signals as SVG."""
        from fieldrig_devices.scenarios.picture import picture

        _write(Path(file), picture(Path(file).stem, self.played, self.played.done))

    def write_pictures(self, folder: Path) -> None:
        """Write the picture of its signals, and one of each property that does not hold, around that instant."""
        from fieldrig_devices.scenarios.picture import picture_of

        self.write_picture(folder / f"{self.file.stem}.svg")
        rules = {one.name: one for one in self.scenario.properties}
        for number, violation in enumerate(self.violations, 1):
            if violation.property in rules:
                drawn = picture_of(self.played, rules[violation.property], violation)
                _write(folder / f"{self.file.stem}-{number}.svg", drawn)

    def line(self, name: str) -> int:
        """Return the line of what was judged; 0 if it has none."""
        return next((one.line for one in self.scenario.properties if one.name == name), 0)


def failures(outcome: Outcome) -> list[tuple[str, str]]:
    """Return the name of each property that does not hold, and of each step that has not come, with the reason."""
    broken = [(one.property, "\n".join(told(outcome.played, one))) for one in outcome.played.violations]
    steps = [(f"step: {act}", _left(act)) for act in outcome.played.unreached]
    unjudged = [] if broken else [(name, NOT_JUDGED) for name in outcome.played.unjudged]
    return [*broken, *steps, *_late(outcome), *unjudged, *_missed(outcome.played)]


def _late(outcome: Outcome) -> list[tuple[str, str]]:
    """Return the steps that came later than the scenario allows."""
    most_ns, played = outcome.scenario.lateness_ns, outcome.played
    if most_ns is None or not played.lateness:
        return []
    late = ((act, ns) for act, ns in zip(played.done, played.lateness, strict=True) if ns > most_ns)
    return [(f"step: {act}", f"it was {ns / MS:.0f} ms late, and may be {most_ns / MS:g} ms") for act, ns in late]


def _missed(played: Played) -> list[tuple[str, str]]:
    """Return what was not judged, as it was lost on its way: a pass could be one of a machine that did wrong."""
    if not played.missed:
        return []
    count = counted(played.missed, "message")
    return [(SEES_ALL, f"the scenario missed {count} or changes of the rig, so no property was judged by them")]


def _left(act: Act) -> str:
    """Return why an action was not done."""
    return f"`{act.milestone}` was not true" if act.when else f"the scenario was over before {seconds(act.at_ns)}"


def lines_of(outcome: Outcome) -> Iterator[str]:
    """Yield a line for each property, and the reason of each that did not hold."""
    yield f"{outcome.file}  ({seconds(outcome.played.length_ns)})"
    broken = dict(failures(outcome))
    for name in outcome.judged:
        yield f"  {'FAILED' if name in broken else 'ok    '}  {name}"
        yield from (f"          {line}" for line in broken.get(name, "").splitlines())
    yield from (f"  note: {note}" for note in outcome.played.notes)


def told(played: Played, violation: Violation) -> list[str]:
    """Return the reason of a violation, the values, and what happened in the time in front of it."""
    values = ", ".join(f"{place} = {_shown(value)}" for place, value in violation.values)
    begin_ns = violation.at_ns - BEFORE_NS
    happened = [(act.at_ns, f"step: {act}") for act in played.done]
    happened += [
        (at_ns, f"{place} = {_shown(value)}")
        for place, track in played.tracks.items()
        for at_ns, value in [one for one in track if one[0] <= violation.at_ns][-MOST_OF_PLACE:]
        if not place.startswith("since(")  # which changes all the time
    ]
    happened.sort(key=lambda one: one[0])
    before = [(at_ns, what) for at_ns, what in happened if begin_ns <= at_ns <= violation.at_ns]
    return [
        f"at {seconds(violation.at_ns)}: {violation.what}",
        *([values] if values else []),
        *([f"in the {BEFORE_NS / MS:g} ms before:"] if before else []),
        *(f"  {seconds(at_ns)}: {what}" for at_ns, what in before[-MOST_TOLD:]),
    ]


def as_json(outcome: Outcome) -> dict[str, Any]:
    return {
        "file": str(outcome.file),
        "length_s": outcome.played.length_ns / S,
        "hash": outcome.played.hash,
        "hash_then": outcome.played.hash_then,
        "properties": outcome.judged,
        "violations": [
            {**one._asdict(), "at_s": one.at_ns / S, "values": dict(one.values)} for one in outcome.played.violations
        ],
        "steps": [
            {"at_s": act.at_ns / S, "step": str(act), **({"late_s": ns / S} if ns is not None else {})}
            for act, ns in zip_longest(outcome.played.done, outcome.played.lateness)
        ],
        "unreached": [{"step": str(act), "why": _left(act)} for act in outcome.played.unreached],
        "unjudged": list(outcome.played.unjudged),
        "missed": outcome.played.missed,
        "notes": list(outcome.played.notes),
    }


def junit(outcomes: Sequence[Outcome]) -> bytes:
    """Return a report for CI with a test for each property."""
    return form.junit("fieldrig scenarios", {str(one.file): _cases(one) for one in outcomes})


def _cases(outcome: Outcome) -> list[form.Case]:
    broken, names = dict(failures(outcome)), outcome.judged
    return [
        form.Case(
            name,
            outcome.wall_s / len(names),
            [form.Failed(broken[name].partition("\n")[0], broken[name])] if name in broken else [],
            file=str(outcome.file),
            line=outcome.line(name),
            output="\n".join(outcome.played.notes),
        )
        for name in names
    ]


def _write(file: Path, text: str) -> None:
    """UsageError for a file that cannot be written."""
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")
    except OSError as cause:
        raise UsageError(f"{file} cannot be written: {cause.strerror or cause}") from cause


def _shown(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
