"""Plays a schedule to a rig in virtual time, and judges it: here, in a branch, or in a worker of a search."""

from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from pathlib import Path
from traceback import extract_tb
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.errors import ControlError, EndlessError, RigError, UsageError
from fieldrig.points.names import split_point
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.scenarios.judge import Judge
from fieldrig_devices.scenarios.places import RigPlace, place_of
from fieldrig_devices.scenarios.property import Property, Violation

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig

MOST_CHANGES: Final = 10_000
"""Changes of a place that are kept for pictures, the last of them."""
HEALED_NS: Final = 1 * MS
"""The time between two looks for the end of the last fault."""

NOTHING_RAISES: Final = "no device raises an exception"
"""The property of every rig, beside those of its scenario: an error of ours, or of the author of a device."""

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
    hash: str
    """The number of all messages and their hash, as of `Rig.trace_hash`."""


def play(
    rig: "Rig",
    schedule: Schedule,
    properties: Sequence[Property],
    length_ns: int,
    *,
    recovery: Schedule = (),
    stops_early: bool = False,
) -> Played:
    """Play a schedule from the present instant on.  RigError for a place or a fault that the rig does not have.

    With `stops_early` it ends at the first instant at which a property does not hold.
    """
    with Stage(rig, schedule, properties, recovery=recovery, stops_early=stops_early) as stage:
        return stage.finish(length_ns)


class Stage(ExitStack):
    """A rig with what is still to happen, and its judge.  A branch of the rig has a copy of it, which goes on alone."""

    def __init__(
        self,
        rig: "Rig",
        schedule: Schedule,
        properties: Sequence[Property],
        *,
        recovery: Schedule = (),
        stops_early: bool = False,
    ) -> None:
        """Begin at the present instant of the rig.  RigError for a place that it does not have.

        `recovery` is what the operator does in the end, when no fault is left; its instants count from there.
        """
        super().__init__()
        self._rig, self._begin_ns = rig, rig.now_ns
        self._acts = deque(sorted(schedule, key=lambda act: act.at_ns))
        self._stops_early, self._recovery = stops_early, recovery
        self._judged = dict.fromkeys(place for one in properties for place in one.places)
        self._places: dict[str, RigPlace] = {}
        self._tracks: dict[str, deque[tuple[int, Value]]] = {}
        for name in (*self._judged, *_written((*schedule, *recovery))):
            self.follow(name)
        self._judge = _judge(properties, {name: track[-1][1] for name, track in self._tracks.items()})
        self._faults: dict[str, None] = {}
        """The buses and devices that have been given faults."""
        self._healed = False
        self._raised: tuple[Violation, ...] = ()
        self.callback(rig.on_instant(self._on_instant))
        rig.trace_hash()

    def follow(self, name: str) -> None:
        """Keep the changes of a place from now on.  RigError if the rig does not have it."""
        if name in self._places:
            return
        place = self._places[name] = place_of(self._rig, name)
        self._tracks[name] = deque([(self.now_ns, place.read())], maxlen=MOST_CHANGES)
        with suppress(ControlError):  # its device has no power now
            self.callback(place.listen(partial(self._on_change, name)))

    @property
    def now_ns(self) -> int:
        """The instant from the begin."""
        return self._rig.now_ns - self._begin_ns

    @property
    def violations(self) -> tuple[Violation, ...]:
        """The violations so far."""
        return (*self._judge.violations, *self._raised)

    def track(self, place: str) -> Track:
        """Return the changes of a place that is followed, so far."""
        return tuple(self._tracks[place])

    @property
    def is_over(self) -> bool:
        """True if it ends at the first violation, and there has been one; a rig in which a device raised ends too."""
        return bool(self._raised) or (self._stops_early and bool(self._judge.violations))

    def add(self, *acts: Act) -> None:
        """Let more happen.  RigError for a place that the rig does not have."""
        for name in _written(acts):
            if self._is_on(split_point(name)[0]):
                self.follow(name)
        self._acts = deque(sorted([*self._acts, *acts], key=lambda act: act.at_ns))
        if self._healed and acts:
            self._healed = False
            self._judge.hurt()

    def run_until(self, until_ns: int) -> None:
        """Let everything happen up to an instant, where what is done at that instant has not happened yet."""
        while not self.is_over:
            self._guarded(self._do_due)
            next_ns = self._acts[0].at_ns if self._acts else until_ns
            if self.now_ns >= until_ns:
                return
            self._guarded(partial(self._run, min(next_ns, until_ns)))

    def finish(self, length_ns: int) -> Played:
        """Play to the end and until the machine has had its time to come back, and judge what had to happen."""
        self.run_until(length_ns)
        if not self.is_over:
            self._guarded(self._do_due)
            self._come_back()
        if not self.is_over:
            self._judge.end(self.now_ns)
        tracks = {name: tuple(track) for name, track in self._tracks.items()}
        return Played(self.violations, self.now_ns, tracks, self._rig.trace_hash())

    def _come_back(self) -> None:
        """Go on to the end of all faults that have one, let the operator do the rest, and wait for what has to come."""
        while self._faults_end() and not self.is_over:
            self.run_until(self.now_ns + HEALED_NS)
        recovery, self._recovery = self._recovery, ()
        if self._acts or any(self._active()):
            return
        self.add(*(act._replace(at_ns=self.now_ns + act.at_ns) for act in recovery))
        while not self.is_over and (self._acts or (self._judge.recovery_ns or 0) > self.now_ns):
            self.run_until(self._acts[-1].at_ns if self._acts else self.now_ns + HEALED_NS)
            self._guarded(self._do_due)
            self._heal()

    def _faults_end(self) -> bool:
        """Return whether there are faults, all of which end by themselves."""
        active = list(self._active())
        return bool(active) and all("duration_ms" in one and one.get("state") == "on" for one in active)

    def _guarded(self, step: Callable[[], None]) -> None:
        """Do a step; what a device raises there is a violation, and the end.  RigError for what a user can fix."""
        try:
            step()
        except EndlessError as endless:
            self._raised = (Violation(NOTHING_RAISES, self.now_ns, endless.what, ()),)
        except RigError:
            raise
        except Exception as wrong:  # noqa: BLE001  whatever a device raises is what is looked for
            self._raised = (Violation(NOTHING_RAISES, self.now_ns, _told(wrong), ()),)

    def _run(self, until_ns: int) -> None:
        """Run from instant to instant; the end of the last fault, which is none, is looked for every millisecond."""
        end_ns = self._begin_ns + until_ns
        while self._rig.now_ns < end_ns and not self.is_over:
            waits = not (self._acts or self._healed)
            look_ns = self._begin_ns + (self.now_ns // HEALED_NS + 1) * HEALED_NS
            last_ns = min(end_ns, look_ns) if waits else end_ns
            next_ns = self._rig.next_ns()
            if next_ns is None or next_ns > last_ns:
                self._rig.run_until(last_ns)
                self._on_instant()
            else:
                self._rig.step()
            if waits:
                self._heal()

    # ---- what happens

    def _do_due(self) -> None:
        while self._acts and self._acts[0].at_ns <= self.now_ns:
            self._do(self._acts.popleft())

    def _do(self, act: Act) -> None:
        rig = self._rig
        match act.verb:
            case "set":
                self._write(act.where, act.value)
            case "press":
                self._press(act)
            case "fault":
                assert isinstance(act.value, Mapping)
                rig.add_fault(act.where, act.value)
                self._faults[act.where] = None
            case "clear":
                for number in list(rig.faults(act.where)):
                    rig.clear_fault(act.where, number)
            case "restart":
                if self._is_on(act.where):
                    rig.restart(act.where)

    def _press(self, act: Act) -> None:
        if self._is_on(split_point(act.where)[0]):
            self.follow(act.where)
            before = self._places[act.where].read()
            self._write(act.where, act.value)
            self.add(Act(act.end_ns, "set", act.where, before))

    def _write(self, where: str, value: object) -> None:
        """Write a place; a key of a device without power does nothing."""
        assert isinstance(value, bool | int | float | str)
        if self._is_on(split_point(where)[0]):
            self.follow(where)
            self._places[where].write(value)

    def _is_on(self, part: str) -> bool:
        """Return whether it is a bus, or a device with power."""
        if part not in self._rig.config.devices:
            return True
        try:
            self._rig.values(part, ())
        except ControlError:
            return False
        return True

    def _heal(self) -> None:
        """Note the instant from which on there is no fault any more."""
        if self._healed or self._acts or self._recovery or any(self._active()):
            return
        self._healed = True
        self._judge.healed(self.now_ns)

    def _active(self) -> Iterator[Mapping[str, object]]:
        return (one for where in self._faults for one in self._rig.faults(where).values() if _is_active(one))

    # ---- what is seen

    def _on_change(self, name: str, value: Value) -> None:
        self._note(name, value)
        if name in self._judged:
            self._judge.change(self.now_ns, name, value)

    def _note(self, name: str, value: Value) -> None:
        track = self._tracks[name]
        if track[-1][1] != value:
            track.append((self.now_ns, value))

    def _on_instant(self) -> None:
        self._judge.look(self.now_ns, self._read())

    def _read(self) -> Mapping[str, Value]:
        """Return the present values; a place of a device without power keeps its last one."""
        values: dict[str, Value] = {}
        for name in self._judged:
            with suppress(ControlError):
                values[name] = self._places[name].read()
                self._note(name, values[name])
        return values


def _written(acts: Iterable[Act]) -> list[str]:
    return [act.where for act in acts if act.verb in ("set", "press")]


def _judge(properties: Iterable[Property], values: Mapping[str, Value]) -> Judge:
    """Return the judge.  UsageError for a property that cannot be judged with such values."""
    for one in properties:
        for expression in filter(None, (one.condition, one.after, one.until)):
            try:
                expression.holds(values)
            except TypeError as wrong:
                shown = ", ".join(f"{place} is {values[place]!r}" for place in expression.places)
                raise UsageError(f"{one.name}: `{expression.text}` cannot be judged: {wrong}", shown) from wrong
    return Judge(tuple(properties), values)


def _told(wrong: Exception) -> str:
    """Return an exception with the line that raised it, and the device and instant of it."""
    *_, frame = extract_tb(wrong.__traceback__)
    notes = "; ".join(getattr(wrong, "__notes__", ()))
    return f"{type(wrong).__name__}: {wrong} ({Path(frame.filename).name}:{frame.lineno}){notes and f' {notes}'}"


def _is_active(fault: Mapping[str, object]) -> bool:
    return fault.get("state") != "over"
