"""The calls in the branches of a rig: the scenario with some actions besides.

A branch has a stage and an eye of its own, which its branches begin from.  The functions take the rig (`Branch.call`),
and what crosses the pipe is small.
"""

from collections.abc import Iterable, Mapping, MutableMapping, Sequence
from contextlib import AbstractContextManager, nullcontext
from itertools import pairwise
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.errors import ControlError, GoneError, RigError
from fieldrig.system.stopwatch import Stopwatch
from fieldrig_devices.scenarios.act import Act
from fieldrig_devices.scenarios.places import RigPlace, place_of
from fieldrig_devices.scenarios.play import Played, Stage
from fieldrig_devices.scenarios.property import Violation
from fieldrig_devices.scenarios.sending import message_of
from fieldrig_devices.search.choices import Choice
from fieldrig_devices.search.eye import Eye, digest_of
from fieldrig_devices.search.fault_choices import matching_parts
from fieldrig_devices.search.piece import Piece, Run
from fieldrig_devices.search.plan import Plan

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


LATER_MS: Final = 1_000_000
"""The start of a fault that is only tried."""


MOST_VALUES: Final = 16
"""Values of a place whose changes are edges; one that has more moves all the time, such as an axis."""


class Nominal(NamedTuple):
    """The run without any action besides; instants are nanoseconds from the begin of the scenario, in their order."""

    violations: tuple[Violation, ...]
    changes: tuple[tuple[int, ...], ...]
    """The instants of each kind of change: a place goes from one value to another."""
    others: tuple[int, ...]
    """The instants at which something else happens, such as a message or the cycle of a task."""
    cpu_s: float


class Present(NamedTuple):
    """The scenario that a process plays."""

    plan: Plan
    stage: Stage
    eye: Eye


_present: list[Present] = []


def begin(rig: "Rig", plan: Plan, *, is_hashed: bool = False) -> None:
    """Begin the scenario, which ends at the first violation.  RigError for a place that the rig does not have."""
    scenario, kind = plan.scenario, Stage
    if scenario.master is not None:
        from fieldrig_devices.scenarios.with_master import MasterStage  # most programs are the rig's

        kind = MasterStage
    stage = kind(
        rig,
        scenario.schedule,
        scenario.properties,
        recovery=scenario.recovery,
        stops_early=True,
        is_hashed=is_hashed,
    )
    _present[:] = [Present(plan, stage, Eye(rig, plan.sorts, plan.states))]


def advance(rig: "Rig", until_ns: int) -> float:
    """Play on to an instant of the nominal run, and return the processor time in seconds."""
    watch, stage = Stopwatch(), _present[0].stage
    stage.run_until(until_ns)
    return watch.busy_seconds


def play_piece(rig: "Rig", piece: Piece) -> Run:
    """Play a piece from where this branch is, which has done what comes before that."""
    watch = Stopwatch()
    with _acting():
        try:
            played = _play_piece(rig, piece)
        except GoneError:
            raise  # the piece is played again
        except RigError as wrong:  # each action alone was tried, so it is the state of the machine that refuses it
            played = _run(piece)._replace(refused=wrong.what)
    return played._replace(cpu_s=played.cpu_s + watch.busy_seconds)


def _play_piece(rig: "Rig", piece: Piece) -> Run:
    plan, stage, eye = _present[0]
    _go_to(piece)
    if piece.is_whole:
        stage.finish(piece.until_ns)
        return _run(piece)
    eye.forget()
    stage.run_until(piece.until_ns)
    states = frozenset(map(digest_of, eye.states()))
    if not plan.recovers or stage.violations:
        return _run(piece)._replace(states=states)
    if plan.scenario.master is not None:  # nothing goes on from here, as the threads of a master cannot be copied
        stage.finish(piece.until_ns)
        return _run(piece)._replace(states=states)
    with rig.branch() as end:  # whether the machine comes back is seen beside, as the next piece may go on from here
        ended = end.call(play_piece, piece._replace(from_ns=piece.until_ns, is_whole=True))
    return _run(piece)._replace(states=states, violations=ended.violations, way=ended.way, cpu_s=ended.cpu_s)


def play_told(rig: "Rig", plan: Plan, piece: Piece) -> Played:
    """Play a whole piece with all that a report needs, from the begin of the scenario, which has not begun."""
    begin(rig, plan, is_hashed=True)
    with _acting():
        _go_to(piece)
        return _present[0].stage.finish(piece.until_ns)


def _acting() -> AbstractContextManager[None]:
    """Have the master of the plan act meanwhile, if it has one."""
    scenario, stage = _present[0].plan.scenario, _present[0].stage
    if scenario.master is None:
        return nullcontext()
    from fieldrig_devices.scenarios.with_master import MasterStage  # most programs are the rig's

    assert isinstance(stage, MasterStage)
    return stage.acting(scenario.master, scenario.jitter_ns, is_quiet=True)


def try_all(rig: "Rig", choices: Iterable[Choice], places: MutableMapping[str, RigPlace]) -> list[Act]:
    """Try each choice once, one after the other, and return those of which the rig has refused the value.

    `places` has those that were written before.  RigError for a place, a fault or a device that the rig does not have.
    """
    refused: list[Act] = []
    for choice in choices:
        for act in choice.all(0):
            match act.verb:
                case "set" | "press":
                    assert isinstance(act.value, bool | int | float | str)
                    if act.where not in places:  # a wire takes one member of this name
                        places[act.where] = place_of(rig, act.where)
                    try:
                        places[act.where].write(act.value)
                    except ControlError:  # maybe because of the values that were tried before
                        refused.append(act)
                case "fault":
                    assert isinstance(act.value, Mapping)
                    rig.clear_fault(act.where, rig.add_fault(act.where, {**act.value, "start_ms": LATER_MS}))
                case "restart":
                    rig.values(act.where, ())
                case "clear":
                    rig.faults(act.where)
                case "send":
                    message_of(rig.buses[matching_parts(rig, [act.where])[0]], str(act.value))
    return refused


def try_alone(rig: "Rig", act: Act) -> None:
    """Write a value.  RigError if the rig refuses it."""
    assert isinstance(act.value, bool | int | float | str)
    place_of(rig, act.where).write(act.value)


def nominal(rig: "Rig", places: Sequence[str], length_ns: int) -> Nominal:
    """Play on to the end, and return the edges on the way: those of these places, and of all that is judged."""
    watch, stage = Stopwatch(), _present[0].stage
    instants = set[int]()
    rig.on_instant(lambda: instants.add(stage.now_ns))
    for name in places:
        stage.follow(name)
    with _acting():
        played = stage.finish(length_ns)
    kinds: dict[tuple[object, ...], list[int]] = {}
    for name, track in played.tracks.items():
        if len({value for _, value in track}) <= MOST_VALUES:
            for (_, before), (at_ns, after) in pairwise(track):
                if 0 < at_ns <= length_ns:
                    kinds.setdefault((name, before, after), []).append(at_ns)
    changes = tuple(map(tuple, kinds.values()))
    others = {at_ns for at_ns in instants if at_ns <= length_ns}.difference(*changes)
    return Nominal(played.violations, changes, tuple(sorted(others)), watch.busy_seconds)


def _go_to(piece: Piece) -> None:
    """Play on to the begin of a piece, with what has not been done yet."""
    stage = _present[0].stage
    stage.forgives = stage.forgives or bool(piece.acts)
    if stage.now_ns < piece.until_ns:
        stage.add(*(act for act in piece.acts if act.at_ns >= stage.now_ns))
    stage.run_until(piece.from_ns)


def _run(piece: Piece) -> Run:
    _, stage, eye = _present[0]
    violations = stage.violations
    way = eye.way() if violations else b""
    return Run(piece.acts, violations, piece.until_ns, world=piece.world, marks=eye.marks(), way=way)
