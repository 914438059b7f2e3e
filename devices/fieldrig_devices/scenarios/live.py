"""Plays a schedule to a rig in real time, and judges it by what its processes record.

Each process notes the instants of its changes itself, and all of them have the clock of the host; so properties are
judged by these instants, a while later.  What real time cannot do is said in the notes of the outcome: actions come
when the rig has taken them, and what was lost was not judged.  Numbers without events are looked at every 10 ms.
"""

from bisect import insort
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.hub.thread_member import ThreadMember
from fieldrig.real.running_rig import RunningRig
from fieldrig_bus.wires import Signal
from fieldrig_devices.scenarios.act import Act, Schedule
from fieldrig_devices.scenarios.expression import expression_of
from fieldrig_devices.scenarios.hands import Hands
from fieldrig_devices.scenarios.live_events import LiveEvents
from fieldrig_devices.scenarios.live_places import LivePlaces
from fieldrig_devices.scenarios.milestones import Milestones
from fieldrig_devices.scenarios.places import MEMBER
from fieldrig_devices.scenarios.property import Property
from fieldrig_devices.scenarios.sending import message_of
from fieldrig_devices.scenarios.tracing import Trace
from fieldrig_devices.scenarios.watching import Played, Watching

STEP_NS: Final = 10 * MS
"""The time between two looks at what has come."""
FAULTS_NS: Final = 100 * MS
"""The time between two questions for the end of the last fault."""
WARNED_NS: Final = 100 * MS
"""An action that is later than this is named in the notes."""
MOST_WARNED: Final = 5
SETTLE_NS: Final = 3 * S
"""The longest wait, at the end, for what has been recorded before."""


class LiveStage(ExitStack):
    """A rig in real time with what is still to happen, and its judge."""

    def __init__(
        self,
        rig: RunningRig,
        config: RigConfig,
        schedule: Schedule,
        properties: Sequence[Property],
        recovery: Schedule = (),
        trace: Trace | None = None,
    ) -> None:
        """Begin now.  RigError for a place that the rig does not have."""
        super().__init__()
        self._rig, self._config, self._recovery = rig, config, recovery
        every = (*schedule, *recovery)
        written = [act.where for act in every if act.verb in ("set", "press")]
        awaited = [name for act in every if act.when for name in expression_of(act.when).places]
        judged = [name for one in properties for name in one.places]
        self._places = LivePlaces(rig, config, [*judged, *awaited, *written])
        driven = {name.partition("/")[0] for name in written} & {*config.buses}
        self._member = self._joined([*driven, *(act.where for act in every if act.verb == "send")])
        self._events = self.enter_context(LiveEvents(rig, config, self._places, trace))
        values = self._events.values
        self._seen = Watching(properties, {name: values[name] for name in dict.fromkeys(judged)})
        for name in dict.fromkeys([*awaited, *written]):
            if name not in self._seen.values:
                self._seen.follow(0, name, values[name])
        self._milestones, self._latest = Milestones(), dict(values)
        self._hands = Hands(rig, self._latest.__getitem__, self._write, self._send, rig.has_power)
        self._acts: list[Act] = []
        self._lateness: list[int] = []
        self._asked_ns = 0
        self._healed_ns, self._is_healed = -1, False
        """The instant from which on nothing is to be done, and there is no fault; -1 before."""
        self._begin_ns = self._events.begin()
        self._add(schedule)

    @property
    def now_ns(self) -> int:
        return self._rig.now_ns() - self._begin_ns

    def finish(self, length_ns: int) -> Played:
        """Play to the end and until the machine has had its time to come back, and judge what had to happen."""
        self._run(length_ns)
        self._come_back()
        end_ns = self.now_ns
        while self._judged_ns < end_ns and self.now_ns < end_ns + SETTLE_NS:
            self._rig.wait(STEP_NS)
            self._take()
        self._seen.end(end_ns)
        played = self._seen.outcome(end_ns, "", [*self._late(), *self._events.notes(self._begin_ns + end_ns)])
        left = (*self._milestones.waiting, *self._acts)
        return played._replace(unreached=left, missed=self._events.missed, lateness=tuple(self._lateness))

    def _late(self) -> Iterator[str]:
        """Yield sentences on how late actions were done."""
        yield f"real time: actions were done up to {max(self._lateness, default=0) / MS:.0f} ms late"
        late = [(ns, act) for ns, act in zip(self._lateness, self._seen.done, strict=True) if ns > WARNED_NS]
        for ns, act in late[:MOST_WARNED]:
            yield f"{ns / MS:.0f} ms late: {act}"
        if len(late) > MOST_WARNED:
            yield f"and {len(late) - MOST_WARNED} others"

    # ---- what happens

    def _add(self, acts: Schedule, begin_ns: int = 0) -> None:
        for act in acts:
            if act.when:
                self._milestones.add(act)
            else:
                insort(self._acts, act._replace(at_ns=begin_ns + act.at_ns), key=_instant)
        self._milestones.look(self.now_ns, self._latest)

    def _run(self, until_ns: int) -> None:
        while True:
            self._take()
            self._do_due()
            rest_ns = min(until_ns, self._acts[0].at_ns if self._acts else until_ns) - self.now_ns
            if self.now_ns >= until_ns:
                return
            self._rig.wait(min(rest_ns, STEP_NS))

    def _do_due(self) -> None:
        for act in self._milestones.reached():
            insort(self._acts, act, key=_instant)
        while self._acts and self._acts[0].at_ns <= self.now_ns:
            act = self._acts.pop(0)
            after = self._hands.do(act)
            done_ns = self.now_ns
            self._lateness.append(done_ns - act.at_ns)
            self._seen.done.append(act._replace(at_ns=done_ns))
            if after is not None:
                insort(self._acts, after._replace(at_ns=done_ns + act.hold_ns), key=_instant)
        self._heal()

    def _come_back(self) -> None:
        """Wait for the end of faults that have one, let the operator do the rest, and wait for what has to come."""
        while self._hands.faults_end():
            self._run(self.now_ns + FAULTS_NS)
        recovery, self._recovery, begin_ns = self._recovery, (), self.now_ns
        if not self._hands.has_faults():
            self._add(recovery, begin_ns)
        while self._acts or self._is_to_heal() or (self._seen.recovery_ns or 0) > self.now_ns:
            self._run(self._acts[-1].at_ns if self._acts else self.now_ns + FAULTS_NS)

    def _is_to_heal(self) -> bool:
        """True if the end of all faults is near, and has not been judged."""
        return not (self._is_healed or self._milestones.waiting or self._hands.has_faults())

    def _heal(self) -> None:
        """Note the instant from which on nothing is to be done, and there is no fault any more."""
        now_ns, waits = self.now_ns, self._acts or self._recovery or self._milestones.waiting
        if self._healed_ns >= 0 or waits or now_ns - self._asked_ns < FAULTS_NS:
            return
        self._asked_ns = now_ns
        if not self._hands.has_faults():
            self._healed_ns = now_ns

    def _write(self, name: str, value: Value) -> None:
        part, _, key = name.partition("/")
        if part in self._config.buses:
            assert self._member is not None
            self._member.send(part, Signal(key, value if isinstance(value, bool | int | float) else False))
        else:
            self._rig.set(name, value)

    def _send(self, bus: str, text: str) -> None:
        assert self._member is not None
        self._member.send(bus, message_of(self._config.buses[bus].bus, text))

    def _joined(self, buses: Sequence[str]) -> ThreadMember | None:
        if not buses:
            return None
        wanted = [self._config.buses[name].bus for name in dict.fromkeys(buses)]
        member = ThreadMember(wanted, Path(self._rig.status()["run"]), MEMBER)
        self.callback(member.close)
        return member

    # ---- what is seen

    @property
    def _judged_ns(self) -> int:
        return self._events.judged_ns - self._begin_ns

    def _take(self) -> None:
        """Judge what is known completely, and look at milestones with the latest values."""
        for at_ns, changes in self._events.instants():
            self._judge(at_ns - self._begin_ns, changes)
        for at_ns, name, value in self._events.news():
            self._latest[name] = value
            self._milestones.look(at_ns - self._begin_ns, self._latest)

    def _judge(self, at_ns: int, changes: Mapping[str, Sequence[Value]]) -> None:
        if 0 <= self._healed_ns <= at_ns and not self._is_healed:
            self._is_healed = True
            self._seen.heal(at_ns)
        for name, values in changes.items():
            for value in values:
                self._seen.change(max(at_ns, 0), name, value)
        self._seen.look(max(at_ns, 0), {})


def _instant(act: Act) -> int:
    return act.at_ns
