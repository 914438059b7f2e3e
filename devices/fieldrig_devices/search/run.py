"""Runs of a search, in branches of a rig: the scenario with some actions besides.

A branch has a stage of its own, which its branches begin from.  The functions are called there (`Branch.call`), so they
take the rig, and what crosses the pipe is small.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.scenarios.play import Played, Stage, Track
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.scenarios.scenario_file import Scenario

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Run(NamedTuple):
    """The outcome of a run."""

    acts: Schedule
    """The actions besides those of the scenario."""
    violations: tuple[Violation, ...]
    length_ns: int
    states: frozenset[tuple[Any, ...]] = frozenset()
    """The states of the machine that it has seen, if they were asked for."""


class Edges(NamedTuple):
    """The instants of a scenario from its begin, in nanoseconds, in their order."""

    changes: tuple[int, ...]
    others: tuple[int, ...]
    """The instants at which something else happens, such as a message or the cycle of a task."""


_stages: list[Stage] = []
"""The stage of this process, once it has begun."""


def begin(rig: "Rig", scenario: Scenario) -> None:
    """Begin the scenario, which ends at the first violation.  RigError for a place that the rig does not have."""
    _stages[:] = [Stage(rig, scenario.schedule, scenario.properties, stops_early=True)]


def advance(rig: "Rig", until_ns: int) -> bool:
    """Play on to an instant; false if a property did not hold before."""
    (stage,) = _stages
    stage.run_until(until_ns)
    return not stage.is_over


def go_on(rig: "Rig", acts: Schedule, length_ns: int) -> Run:
    """Play on to the end, with actions that come from now on."""
    (stage,) = _stages
    stage.add(*acts)
    played = stage.finish(length_ns)
    return Run(acts, played.violations, played.length_ns)


def go_on_for(rig: "Rig", acts: Schedule, until_ns: int, states: Sequence[str]) -> Run:
    """Play on to an instant, where it can go on, and note the states of the machine on the way."""
    (stage,) = _stages
    from_ns = stage.now_ns
    stage.add(*acts)
    for name in states:
        stage.follow(name)
    stage.run_until(until_ns)
    seen = _states({name: stage.track(name) for name in states}, from_ns)
    return Run(acts, stage.violations, stage.now_ns, seen)


def edges(rig: "Rig", places: Sequence[str], length_ns: int) -> Edges:
    """Play on to the end, and return the edges on the way: those of these places, and of all that is judged."""
    (stage,) = _stages
    instants = set[int]()
    rig.on_instant(lambda: instants.add(stage.now_ns))
    for name in places:
        stage.follow(name)
    tracks = stage.finish(length_ns).tracks
    changes = {at_ns for track in tracks.values() for at_ns, _ in track if at_ns > 0}
    return Edges(tuple(sorted(changes)), tuple(sorted(instants - changes)))


def play_all(rig: "Rig", scenario: Scenario, acts: Schedule, length_ns: int) -> Played:
    """Play the scenario with actions from its begin, with all that a report needs."""
    with Stage(rig, scenario.schedule, scenario.properties, stops_early=True) as stage:
        stage.add(*acts)
        return stage.finish(length_ns)


def _states(tracks: dict[str, Track], from_ns: int) -> frozenset[tuple[Any, ...]]:
    """Return the states that the places have had since an instant, as tuples of their values."""
    changes = sorted(
        ((at_ns, name, value) for name, track in tracks.items() for at_ns, value in track), key=lambda one: one[0]
    )
    now: dict[str, Any] = {name: track[0][1] for name, track in tracks.items()}
    found = set()
    for at_ns, name, value in changes:
        now[name] = _coarse(value)
        if at_ns >= from_ns:
            found.add(tuple(now.values()))
    return frozenset(found | {tuple(now.values())})


def _coarse(value: object) -> object:
    """Return a value as a part of a state: of a real number only its order of magnitude says something new."""
    return float(f"{value:.0e}") if isinstance(value, float) else value
