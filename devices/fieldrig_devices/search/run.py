"""What is called in the branches of a rig: the scenario with some actions besides.

A branch has a stage of its own, which its branches begin from.  The functions take the rig (`Branch.call`), and what
crosses the pipe is small.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from fieldrig_devices.scenarios.act import Schedule
from fieldrig_devices.scenarios.play import Played, Stage, Track
from fieldrig_devices.scenarios.scenario_file import Scenario
from fieldrig_devices.search.piece import Piece, Run

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Edges(NamedTuple):
    """The instants of a scenario from its begin, in nanoseconds, in their order."""

    changes: tuple[int, ...]
    others: tuple[int, ...]
    """The instants at which something else happens, such as a message or the cycle of a task."""


_stages: list[Stage] = []
"""The stage of this process, once it has begun."""


def begin(rig: "Rig", scenario: Scenario) -> None:
    """Begin the scenario, which ends at the first violation.  RigError for a place that the rig does not have."""
    _stages[:] = [_stage(rig, scenario)]


def advance(rig: "Rig", until_ns: int) -> None:
    """Play on to an instant."""
    (stage,) = _stages
    stage.run_until(until_ns)


def play_piece(rig: "Rig", piece: Piece, states: Sequence[str]) -> Run:
    """Play a piece from where this branch is, which has done what comes before that."""
    (stage,) = _stages
    stage.add(*(act for act in piece.acts if act.at_ns >= stage.now_ns))
    stage.run_until(piece.from_ns)
    if piece.is_whole:
        played = stage.finish(piece.until_ns)
        return Run(piece.acts, played.violations, played.length_ns)
    for name in states:
        stage.follow(name)
    stage.run_until(piece.until_ns)
    seen = _states({name: stage.track(name) for name in states}, piece.from_ns)
    return Run(piece.acts, stage.violations, stage.now_ns, seen)


def edges(rig: "Rig", places: Sequence[str], length_ns: int) -> Edges:
    """Play on to the end, and return the edges on the way: those of these places, and of all that is judged."""
    (stage,) = _stages
    instants = set[int]()
    rig.on_instant(lambda: instants.add(stage.now_ns))
    for name in places:
        stage.follow(name)
    tracks = stage.finish(length_ns).tracks
    changes = {at_ns for track in tracks.values() for at_ns, _ in track if 0 < at_ns <= length_ns}
    return Edges(tuple(sorted(changes)), tuple(sorted({at_ns for at_ns in instants if at_ns <= length_ns} - changes)))


def play_all(rig: "Rig", scenario: Scenario, acts: Schedule, length_ns: int) -> Played:
    """Play the scenario with actions from its begin, with all that a report needs."""
    with _stage(rig, scenario) as stage:
        stage.add(*acts)
        return stage.finish(length_ns)


def _stage(rig: "Rig", scenario: Scenario) -> Stage:
    return Stage(rig, scenario.schedule, scenario.properties, recovery=scenario.recovery, stops_early=True)


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
