"""What is called in the branches of a rig: the scenario with some actions besides.

A branch has a stage and an eye of its own, which its branches begin from.  The functions take the rig (`Branch.call`),
and what crosses the pipe is small.
"""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple

from fieldrig_devices.scenarios.play import Played, Stage
from fieldrig_devices.scenarios.property import Kind
from fieldrig_devices.search.eye import Eye
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Edges(NamedTuple):
    """The instants of a scenario from its begin, in nanoseconds, in their order."""

    changes: tuple[int, ...]
    others: tuple[int, ...]
    """The instants at which something else happens, such as a message or the cycle of a task."""


class Present(NamedTuple):
    """What a process has of the scenario that it plays."""

    stage: Stage
    eye: Eye
    recovers: bool
    """True if a property says that the machine comes back in the end."""


_present: list[Present] = []


def begin(rig: "Rig", plan: Plan) -> None:
    """Begin the scenario, which ends at the first violation.  RigError for a place that the rig does not have."""
    scenario = plan.scenario
    stage = Stage(rig, scenario.schedule, scenario.properties, recovery=scenario.recovery, stops_early=True)
    recovers = any(one.kind is Kind.EVENTUALLY for one in scenario.properties)
    _present[:] = [Present(stage, Eye(rig, plan.sorts, plan.states), recovers)]


def advance(rig: "Rig", until_ns: int) -> None:
    """Play on to an instant."""
    _present[0].stage.run_until(until_ns)


def play_piece(rig: "Rig", piece: Piece) -> Run:
    """Play a piece from where this branch is, which has done what comes before that."""
    stage, eye, recovers = _present[0]
    _go_to(piece)
    if piece.is_whole:
        stage.finish(piece.until_ns)
        return _run(piece)
    eye.forget()
    stage.run_until(piece.until_ns)
    if not recovers or stage.violations:
        return _run(piece)._replace(states=eye.states())
    with rig.branch() as end:  # whether the machine comes back is seen beside, as the next piece may go on from here
        ended = end.call(play_piece, piece._replace(from_ns=piece.until_ns, is_whole=True))
    return _run(piece)._replace(states=eye.states(), violations=ended.violations, way=ended.way)


def play_told(rig: "Rig", piece: Piece) -> Played:
    """Play a whole piece with all that a report needs."""
    _go_to(piece)
    return _present[0].stage.finish(piece.until_ns)


def edges(rig: "Rig", places: Sequence[str], length_ns: int) -> Edges:
    """Play on to the end, and return the edges on the way: those of these places, and of all that is judged."""
    stage = _present[0].stage
    instants = set[int]()
    rig.on_instant(lambda: instants.add(stage.now_ns))
    for name in places:
        stage.follow(name)
    tracks = stage.finish(length_ns).tracks
    changes = {at_ns for track in tracks.values() for at_ns, _ in track if 0 < at_ns <= length_ns}
    return Edges(tuple(sorted(changes)), tuple(sorted({at_ns for at_ns in instants if at_ns <= length_ns} - changes)))


def _go_to(piece: Piece) -> None:
    """Play on to the begin of a piece, with what has not been done yet."""
    stage = _present[0].stage
    if stage.now_ns < piece.until_ns:
        stage.add(*(act for act in piece.acts if act.at_ns >= stage.now_ns))
    stage.run_until(piece.from_ns)


def _run(piece: Piece) -> Run:
    stage, eye, _ = _present[0]
    violations = stage.violations
    way = eye.way() if violations else b""
    return Run(piece.acts, violations, piece.until_ns, world=piece.world, marks=eye.marks(), way=way)
