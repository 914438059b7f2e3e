"""Plays a schedule to a rig in virtual time, and judges it: here, in a branch, or in a worker of a search."""

from collections import deque
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import ExitStack, suppress
from functools import partial
from typing import TYPE_CHECKING, Final, NamedTuple

from fieldrig.clock import MS
from fieldrig.device import Value
from fieldrig.errors import ControlError, UsageError
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
    rig: "Rig", schedule: Schedule, properties: Sequence[Property], length_ns: int, *, stops_early: bool = False
) -> Played:
    """Play a schedule from the present instant on.  RigError for a place or a fault that the rig does not have.

    With `stops_early` it ends at the first instant at which a property does not hold.
    """
    with _Stage(rig, schedule, properties) as stage:
        return stage.play(length_ns, stops_early=stops_early)


class _Stage(ExitStack):
    """The rig with its listeners."""

    def __init__(self, rig: "Rig", schedule: Schedule, properties: Sequence[Property]) -> None:
        super().__init__()
        self._rig, self._begin_ns = rig, rig.now_ns
        self._acts = deque(sorted(schedule, key=lambda act: act.at_ns))
        judged = [place for one in properties for place in one.places]
        acted = [act.where for act in schedule if act.verb in ("set", "press")]
        self._places: dict[str, RigPlace] = {name: place_of(rig, name) for name in dict.fromkeys([*judged, *acted])}
        self._judged = dict.fromkeys(judged)
        values = {name: place.read() for name, place in self._places.items()}
        self._tracks = {name: deque([(0, value)], maxlen=MOST_CHANGES) for name, value in values.items()}
        self._judge = _judge(properties, values)
        self._healed = False
        self._where = dict.fromkeys(act.where for act in schedule if act.verb == "fault")
        for name, place in self._places.items():
            with suppress(ControlError):  # its device has no power now
                self.callback(place.listen(partial(self._on_change, name)))
        self.callback(rig.on_instant(self._on_instant))
        rig.trace_hash()

    @property
    def _now_ns(self) -> int:
        return self._rig.now_ns - self._begin_ns

    def play(self, length_ns: int, *, stops_early: bool) -> Played:
        stop: Callable[[], object] = (lambda: self._judge.violations) if stops_early else (lambda: False)
        while not stop():
            self._act()
            next_ns = self._acts[0].at_ns if self._acts else length_ns
            if not self._acts:
                self._heal()
            if self._now_ns >= length_ns:
                break
            self._run_until(min(next_ns, length_ns), stop)
        if not stop():
            self._judge.end(self._now_ns)
        tracks = {name: tuple(track) for name, track in self._tracks.items()}
        return Played(tuple(self._judge.violations), self._now_ns, tracks, self._rig.trace_hash())

    def _run_until(self, until_ns: int, stop: Callable[[], object]) -> None:
        """Run from instant to instant; the end of the last fault, which is none, is looked for every millisecond."""
        end_ns = self._begin_ns + until_ns
        while self._rig.now_ns < end_ns and not stop():
            waits = not (self._acts or self._healed)
            look_ns = self._begin_ns + (self._now_ns // HEALED_NS + 1) * HEALED_NS
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

    def _act(self) -> None:
        while self._acts and self._acts[0].at_ns <= self._now_ns:
            self._do(self._acts.popleft())

    def _do(self, act: Act) -> None:
        rig = self._rig
        match act.verb:
            case "set":
                self._write(act.where, act.value)
            case "press":
                before = self._places[act.where].read()
                self._write(act.where, act.value)
                self._add(Act(act.end_ns, "set", act.where, before))
            case "fault":
                assert isinstance(act.value, Mapping)
                rig.add_fault(act.where, act.value)
            case "clear":
                for number in list(rig.faults(act.where)):
                    rig.clear_fault(act.where, number)
            case "restart":
                rig.restart(act.where)

    def _write(self, where: str, value: object) -> None:
        assert isinstance(value, bool | int | float | str)
        self._places[where].write(value)

    def _add(self, act: Act) -> None:
        self._acts = deque(sorted([*self._acts, act], key=lambda one: one.at_ns))

    def _heal(self) -> None:
        """Note the instant from which on there is no fault any more."""
        if self._healed or any(
            _is_active(fault) for where in self._where for fault in self._rig.faults(where).values()
        ):
            return
        self._healed = True
        self._judge.healed(self._now_ns)

    # ---- what is seen

    def _on_change(self, name: str, value: Value) -> None:
        self._note(name, value)
        if name in self._judged:
            self._judge.change(self._now_ns, name, value)

    def _note(self, name: str, value: Value) -> None:
        track = self._tracks[name]
        if track[-1][1] != value:
            track.append((self._now_ns, value))

    def _on_instant(self) -> None:
        self._judge.look(self._now_ns, self._read())

    def _read(self) -> Mapping[str, Value]:
        """Return the present values; a place of a device without power keeps its last one."""
        values: dict[str, Value] = {}
        for name in self._judged:
            with suppress(ControlError):
                values[name] = self._places[name].read()
                self._note(name, values[name])
        return values


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


def _is_active(fault: Mapping[str, object]) -> bool:
    return fault.get("state") != "over"
