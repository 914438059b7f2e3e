"""The calls of users: two logs compared, and a log played back to a rig."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import RigConfig, load
from fieldrig.errors import ArgumentError, UsageError
from fieldrig.text.nearest import closest
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read
from fieldrig.virtual.rig import Rig
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.replay.comparison import HORIZON_NS, TOLERANCE_NS, compare_logs
from fieldrig_devices.replay.diff_result import DiffResult
from fieldrig_devices.replay.judge import NOTHING_EXPECTED, Judge
from fieldrig_devices.replay.leave_out import LeftOut
from fieldrig_devices.replay.log_lines import lines_of
from fieldrig_devices.replay.log_names import LogNames
from fieldrig_devices.replay.pace import Pace
from fieldrig_devices.replay.pauses import shortened
from fieldrig_devices.replay.replay_result import ReplayResult
from fieldrig_devices.replay.selection import Selection, without
from fieldrig_devices.replay.sides import Sides
from fieldrig_devices.replay.start import begin_of
from fieldrig_devices.replay.tolerances import TIME_NS, Tolerances
from fieldrig_devices.replay.virtual import play as play_virtual

TAKE_OUT: Final = "take it out of the rig file, or play in virtual time"


def diff(
    left: str | Path,
    right: str | Path,
    *,
    rig: str | Path | RigConfig | None = None,
    eds: Mapping[int, str | Path] | None = None,
    registers: Mapping[int, str | Path] | None = None,
    tolerance_ns: int = TOLERANCE_NS,
    window_ns: int = HORIZON_NS,
    offset_ns: int | None = None,
    leave_out: Sequence[str] = (),
    begin_ns: int | None = None,
    duration_ns: int | None = None,
) -> DiffResult:
    """Compare two logs in files of any format.

    Jitter up to `tolerance_ns` is no difference; messages further apart than `window_ns` are different ones.
    `offset_ns` is how much later the right log is, and None finds it.  `leave_out` has patterns as for `fieldrig diff`.
    With a rig, or with EDS files by node-ID and register tables by unit, values have names.  `begin_ns` and
    `duration_ns` choose a part of the time of both, as for `read_trace`.  UsageError for a file that is no log,
    ConfigError for mistakes in a rig file, an EDS or a table.
    """
    named = NamedLog(_paths(eds), _paths(registers), load(rig) if isinstance(rig, str | Path) else rig)
    return compare_logs(
        lambda: read(Path(left), begin_ns, duration_ns),
        lambda: read(Path(right), begin_ns, duration_ns),
        tolerance_ns=tolerance_ns,
        horizon_ns=window_ns,
        offset=offset_ns,
        leave_out=LeftOut(leave_out),
        names=(LogNames(named), LogNames(named)),
    )


def _paths(files: Mapping[int, str | Path] | None) -> dict[int, Path]:
    return {number: Path(file) for number, file in (files or {}).items()}


def replay(
    log: str | Path | Iterable[TraceEntry],
    rig: str | Path | RigConfig | Rig,
    *,
    play: Sequence[str] = (),
    time_tolerance_ns: int = TIME_NS,
    value_tolerances: Mapping[str, float] | None = None,
    leave_out: Sequence[str] = (),
    timeout_ns: int = S,
    settle_ns: int | None = None,
    buses: Mapping[str, str] | None = None,
    speed: float | None = None,
) -> ReplayResult:
    """Play one side of a log to a rig, and compare what the rig sends with the other side of the log.

    `play` says what is played: the words of `fieldrig replay --play`, by default everything that no device of the rig
    sends.  Answers may be `time_tolerance_ns` faster or slower than in the log; `value_tolerances` are differences of
    values by object (`6064h`) or register, and `leave_out` has patterns of objects, registers and identifiers.  An
    answer is awaited for `timeout_ns`.  The rig runs for `settle_ns` before the log begins; by default not at all if
    the log shows how it boots, and else for a second.  Nodes that are on when the log begins are awaited until they
    have booted, unless `settle_ns` is 0.  `buses` are the buses of the rig by those of the log, where names and
    families do not say it.

    A `Rig` goes on from its present instant; a file or a configuration is started and closed.  With a `speed` a rig
    file is played in real time, that many times faster than recorded, to the rig that runs at its control endpoint, or
    else to one that is started.  UsageError for a file that is no log, or has nothing of this rig.
    """
    if timeout_ns < MS:
        raise UsageError("an answer is awaited for less than 1 ms", "give a longer --timeout, such as 1s")
    if isinstance(rig, Rig | RigConfig):
        config = rig.config if isinstance(rig, Rig) else rig
    else:
        config = load(rig, ("time=virtual",) if speed is None else ())
    seen: set[str] = set()
    entries = lines_of(read(Path(log)) if isinstance(log, str | Path) else log, config, buses or {}, seen)
    for bus in (buses or {}).values():
        if bus not in config.buses:
            raise UsageError(f"the rig has no bus {bus!r}", closest(bus, list(config.buses)))
    selection = Selection.of(play, config)
    sides, result = Sides(config, selection, buses or {}), ReplayResult()
    entries = shortened(entries, result.note)
    tolerances = Tolerances(time_tolerance_ns, value_tolerances or {}, leave_out)
    named = NamedLog(config=config)
    judge = Judge((LogNames(named), LogNames(named)), tolerances, result)
    if isinstance(rig, Rig):
        if selection.devices:
            raise ArgumentError(f"the rig has {', '.join(sorted(selection.devices))}", "give its file, to leave it out")
        _play(entries, rig, sides, judge, timeout_ns, settle_ns, is_prepared=rig.now_ns > 0)
        _tell_unmet(sides, seen, judge)
        return result
    if speed is not None:
        from fieldrig_devices.replay.live import play as play_live  # virtual time needs no process and no socket

        if selection.devices:
            raise UsageError(f"{config.name} runs with {', '.join(sorted(selection.devices))}", TAKE_OUT)
        play_live(
            lambda now_ns: _begun(entries, sides, judge, now_ns, settle_ns, timeout_ns, speed), config, sides, judge
        )
        _tell_absent(sides, judge, config.name)
        _tell_unmet(sides, seen, judge)
        return result
    with Rig(without(config, selection.devices)) as running:
        _play(entries, running, sides, judge, timeout_ns, settle_ns)
    _tell_unmet(sides, seen, judge)
    return result


def _play(
    entries: Iterable[TraceEntry],
    rig: Rig,
    sides: Sides,
    judge: Judge,
    timeout_ns: int,
    settle_ns: int | None,
    *,
    is_prepared: bool = False,
) -> None:
    log, pace = _begun(entries, sides, judge, rig.now_ns, settle_ns, timeout_ns, 1.0, is_prepared=is_prepared)
    play_virtual(log, rig, sides, judge, pace)
    _tell_absent(sides, judge, rig.config.name)


def _begun(
    entries: Iterable[TraceEntry],
    sides: Sides,
    judge: Judge,
    now_ns: int,
    settle_ns: int | None,
    timeout_ns: int,
    speed: float,
    *,
    is_prepared: bool = False,
) -> tuple[Iterable[TraceEntry], Pace]:
    begin = begin_of(entries, sides, now_ns, settle_ns, is_prepared=is_prepared)
    judge.was_on, judge.log_ns = begin.heard_ns > 0, begin.log_ns
    judge.buses.update(begin.buses)
    if begin.started:
        nodes = ", ".join(map(str, begin.started))
        who, it = (f"the nodes {nodes} are", "they are") if len(begin.started) > 1 else (f"node {nodes} is", "it is")
        judge.result.note(f"{who} operational when the log begins, so {it} started before")
    pace = Pace(
        begin.begin_ns, begin.log_ns, speed, timeout_ns, begin.heard_ns, begin.ready_ns, begin.awaited, settle_ns != 0
    )
    return begin.log, pace


def _tell_unmet(sides: Sides, seen: Collection[str], judge: Judge) -> None:
    """Report the words of the user that name nothing.  UsageError for a bus or a side that the log does not have."""
    for bus in sides.buses:
        if bus not in seen:
            raise UsageError(f"the log has no bus {bus!r}", closest(bus, sorted(seen)))
    if sides.asked:
        word = sides.asked[0].word
        raise UsageError(f"--play {word}: the log has no such messages", closest(word, sorted(sides.seen)))
    for sentence in judge.tolerances.unmet():
        judge.result.note(sentence)


def _tell_absent(sides: Sides, judge: Judge, name: str) -> None:
    """Report what the rig does not have.

    UsageError for a log of another machine: one that shows nodes or units, but none of this rig.
    """
    if (sides.absent or not judge.result.played) and not judge.expected:
        notes = [note for note in judge.result.notes if note != NOTHING_EXPECTED] + judge.result.left_out
        absent = [f"the rig does not have {sides.absent.text}"] if sides.absent else []
        raise UsageError(
            f"the log has nothing of the devices of {name}", "; ".join(absent + notes) or "it has no messages"
        )
    sides.absent.tell(judge, judge.log_ns)
    judge.result.differences.sort(key=attrgetter("time_ns"))
