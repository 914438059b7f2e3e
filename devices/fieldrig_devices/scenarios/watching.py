"""Watches a scenario in either time: the changes of its places, its judge, and its milestones."""

from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from typing import Final, NamedTuple

from fieldrig.device import Value
from fieldrig.errors import UsageError
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.expression import Expression, expression_of
from fieldrig_devices.scenarios.judge import Judge
from fieldrig_devices.scenarios.milestones import Milestones
from fieldrig_devices.scenarios.property import Property, Violation

MOST_CHANGES: Final = 10_000
"""Changes of a place that are kept for pictures, the last of them."""

Track = Sequence[tuple[int, Value]]
"""The changes of a place: instants from the begin of the scenario, in nanoseconds, and values."""


class Played(NamedTuple):
    """The outcome of a scenario."""

    violations: tuple[Violation, ...]
    """In the order in which they were seen."""
    length_ns: int
    """The time that was played."""
    tracks: Mapping[str, Track]
    """The places of properties and actions, with their changes."""
    hash: str = ""
    """The number of all messages and their hash, as of `Rig.trace_hash`; empty in real time."""
    hash_then: str = ""
    """The same up to the first violation, as of a finding of a search, which ends there; empty without one."""
    done: tuple[Act, ...] = ()
    """The actions that were done, at their instants."""
    unreached: tuple[Act, ...] = ()
    """The actions that were not done, as their milestones were not reached, or the scenario was over before."""
    unjudged: tuple[str, ...] = ()
    """The properties that could not be judged, because there was a fault or an action left."""
    notes: tuple[str, ...] = ()
    """Remarks on what real time could not judge, as sentences."""
    lateness: tuple[int, ...] = ()
    """The time by which each of `done` came late, in nanoseconds; nothing in virtual time, where none does."""
    missed: int = 0
    """Messages and changes that were lost on their way to the judge, in real time."""


class Watching:
    """Takes all changes in the order of time; times are nanoseconds from the begin of the scenario."""

    def __init__(self, properties: Sequence[Property], values: Mapping[str, Value]) -> None:
        """`values` are those of all places of properties.  UsageError for a property that cannot be judged so."""
        for one in properties:
            for expression in filter(None, (one.condition, one.after, one.until)):
                check_judged(one.name, expression, values)
        self._judge = Judge(properties, values)
        self._tracks = {name: deque([(0, value)], maxlen=MOST_CHANGES) for name, value in values.items()}
        self.milestones = Milestones()
        self._others: list[Violation] = []
        """Violations of the properties of every rig."""
        self.has_raised = False
        """True if a device has raised an exception."""
        self.done: list[Act] = []
        """The actions that were done."""

    def follow(self, at_ns: int, name: str, value: Value) -> None:
        """Keep the changes of another place."""
        self._tracks[name] = deque([(at_ns, value)], maxlen=MOST_CHANGES)
        self._judge.values[name] = value

    def await_milestone(self, act: Act) -> None:
        """Wait for the milestone of an action, whose places are followed.  UsageError if it cannot be judged."""
        condition = expression_of(act.when)
        check_judged(str(act), condition, self._judge.values)
        self.milestones.add(act)

    @property
    def values(self) -> Mapping[str, Value]:
        """The present values of all places."""
        return self._judge.values

    @property
    def violations(self) -> tuple[Violation, ...]:
        return (*self._judge.violations, *self._others)

    def track(self, name: str) -> Track:
        return tuple(self._tracks[name])

    def change(self, at_ns: int, name: str, value: Value) -> None:
        """Take a change."""
        self._note(at_ns, name, value)
        self._judge.change(at_ns, name, value)
        self.milestones.look(at_ns, self._judge.values)

    def look(self, at_ns: int, values: Mapping[str, Value]) -> None:
        """Take the values at the end of an instant, which may have changed without an event."""
        for name, value in values.items():
            self._note(at_ns, name, value)
        self._judge.look(at_ns, values)
        self.milestones.look(at_ns, self._judge.values)

    @property
    def recovery_ns(self) -> int | None:
        """The latest instant at which the machine has to have come back; None if it is not waited for."""
        return self._judge.recovery_ns

    def raised(self, violation: Violation) -> None:
        """Note that a device has raised an exception, or does not end, so that nothing can go on."""
        self.has_raised = True
        self._others.append(violation)

    def note(self, violation: Violation) -> None:
        """Note a violation of a property of every rig, with which all goes on."""
        self._others.append(violation)

    def heal(self, at_ns: int) -> None:
        """Note that all actions are over, and that there is no fault any more."""
        self._judge.healed(at_ns)

    def hurt(self) -> None:
        """Note that more happens after all was over."""
        self._judge.hurt()

    def end(self, at_ns: int) -> None:
        """Judge what had to happen until now."""
        self._judge.end(at_ns)

    @property
    def is_violated(self) -> bool:
        """True if there has been a violation."""
        return bool(self._judge.violations or self._others)

    def outcome(self, at_ns: int, trace_hash: str = "", notes: Iterable[str] = ()) -> Played:
        """Return the outcome so far."""
        tracks = {name: tuple(track) for name, track in self._tracks.items()}
        unjudged = self._judge.unjudged
        done = tuple(self.done)
        return Played(self.violations, at_ns, tracks, trace_hash, "", done, (), unjudged, tuple(notes))

    def _note(self, at_ns: int, name: str, value: Value) -> None:
        track = self._tracks[name]
        if track[-1][1] != value:
            track.append((at_ns, value))


def check_judged(name: str, expression: Expression, values: Mapping[str, Value]) -> None:
    """UsageError for an expression that cannot be judged with such values."""
    try:
        expression.holds(values)
    except TypeError as wrong:
        shown = ", ".join(f"{place} is {values[place]!r}" for place in expression.places)
        raise UsageError(f"{name}: `{expression.text}` cannot be judged: {wrong}", shown) from wrong
