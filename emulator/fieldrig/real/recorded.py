"""The devices and buses of a process in real time, as recordings see them.

A row is taken as soon as the event of its instant has been handled, and read at that instant: the answer to a cycle has
then left, and a value that moves by itself need not be computed for another instant.  A drive's position costs 2.4 us
at the instant of its cycle and 66 us four milliseconds later.
"""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import ClassVar

from fieldrig.clock import NEVER_NS, Alarm
from fieldrig.device import Device, Value
from fieldrig.errors import ControlError
from fieldrig.points.values import is_another
from fieldrig.real.process import DeviceProcess
from fieldrig.real.switched import Switched
from fieldrig.real.ticks import Ticks
from fieldrig.recording.bus_signals import BusSignals
from fieldrig.recording.device_points import PointReads, describe
from fieldrig.recording.signals import REST_NS, Described, End, OnCycle, RecordedPart
from fieldrig.text.nearest import closest


class ProcessSource:
    """The devices and hubs of one process (`recording.signals.Source`)."""

    def __init__(self, process: DeviceProcess) -> None:
        self._process, self.clock = process, process.clock
        self._loop = asyncio.get_running_loop()
        self._due: dict[OnCycle, int] = {}
        """The rows to take, each with the number of cycles before it that were missed."""
        self._due_ns = NEVER_NS
        self._ticks: list[Ticks] = []
        self._looks: list[Callable[[], None]] = []
        self._is_dirty = False
        self.on_rows: Callable[[], None] = lambda: None

    def now_ns(self) -> int:
        """Return the instant up to which all rows have been taken."""
        next_ns = (ticks.next_ns - 1 for ticks in self._ticks)
        return min(self.clock.now_ns(), self._due_ns if self._due else NEVER_NS, *next_ns)

    def part(self, name: str) -> RecordedPart:
        process = self._process
        if name in process.hubs:
            hub = process.hubs[name]
            return BusSignals(hub.bus, hub.model.standing, hub.on_delivery, self.clock.now_ns)
        if name in process.devices:
            return DeviceSignals(self, name, process.devices[name])
        raise ControlError(
            f"{process.plan.name} has no device or bus {name!r}", closest(name, [*process.devices, *process.hubs])
        )

    def every(self, period_ns: int, action: Callable[[int, int], None]) -> End:
        """Call `action` at each multiple of the period, read at its instant also when the host is late (`ticks.py`)."""
        clock = self.clock
        ticks = Ticks(clock, period_ns, action)
        self._ticks.append(ticks)
        clock.before_event = self._before

        def due() -> None:
            ticks.take_before(clock.now_ns() + 1)
            alarm.at(ticks.next_ns, due)
            if period_ns < REST_NS:  # rows of a device at rest can wait, and one with a cycle has its own good time
                self.on_rows()

        def end() -> None:
            alarm.stop()
            if ticks in self._ticks:
                self._ticks.remove(ticks)

        alarm = Alarm(clock)
        alarm.at(ticks.next_ns, due)
        return end

    def after_cycle(self, action: OnCycle) -> None:
        """Call `action` when the present event has been handled: after its timer, or else after the answer to a cycle.

        A late process handles several events together, and the row of each is taken before the next one.
        """
        if not self._due:
            self._due_ns = self.clock.now_ns()
            self.clock.after_timer, self.clock.before_event = self._take, self._before
            self._loop.call_soon(self._take)
        self._due[action] = self._due.get(action, -1) + 1

    def _before(self, instant_ns: int) -> None:
        """Take what an event at this instant could change."""
        self._take_due()
        for ticks in self._ticks:
            ticks.take_before(instant_ns)
        if not self._ticks:
            self.clock.before_event = None

    def _take(self) -> None:
        if self._due:
            self._take_due()
            self.on_rows()

    def _take_due(self) -> None:
        due, self._due = self._due, {}
        self.clock.after_timer = None
        if due:
            self.clock.look_at(self._due_ns, self._take_now, due)

    def _take_now(self, due: Mapping[OnCycle, int]) -> None:
        now_ns = self.clock.now_ns()
        for action, missed in due.items():
            action(now_ns, missed)

    def watch(self, look: Callable[[], None]) -> End:
        """Call `look` after events of this process, once for those that are handled together."""
        self._looks = [*self._looks, look]
        self.clock.on_event = self._note_event

        def end() -> None:
            self._looks = [other for other in self._looks if other is not look]
            if not self._looks:
                self.clock.on_event = None

        return end

    def _note_event(self) -> None:
        if not self._is_dirty:
            self._is_dirty = True
            self._loop.call_soon(self._look)

    def _look(self) -> None:
        self._is_dirty = False
        for look in self._looks:
            self.clock.look_at(0, look)  # at the latest instant of an event


class DeviceSignals:
    """The points of one device (`recording.signals.RecordedPart`)."""

    is_bus: ClassVar[bool] = False

    def __init__(self, source: ProcessSource, name: str, device: Switched) -> None:
        self._source, self._name, self._switched = source, name, device

    def _present(self) -> Device | None:
        return self._switched.present if self._switched.is_on else None

    def describe(self, keys: Sequence[str]) -> list[Described]:
        return self._source.clock.look(lambda: describe(self._name, self._switched.present, keys))

    def reader(self, keys: Sequence[str]) -> Callable[[], Sequence[Value]]:
        return PointReads(self._present, keys)

    def on_cycle(self, action: OnCycle) -> End | None:
        if not self._switched.present.has_cycle:
            return None
        return self._switched.cycle_hook.add(partial(self._source.after_cycle, action))

    def close(self) -> None:
        """Do nothing: a device is read only when a row is taken."""

    def on_change(self, keys: Sequence[str], action: Callable[[int, int, Value], None]) -> End:
        reads, now_ns = PointReads(self._present, keys), self._source.clock.now_ns
        last: list[Value] = self._source.clock.look(reads)

        def look() -> None:
            for place, value in enumerate(reads()):
                if is_another(value, last[place]):
                    last[place] = value
                    action(now_ns(), place, value)

        ends = [self._source.watch(look), self._switched.watched.hook.add(look)]

        def end() -> None:
            for each in ends:
                each()

        return end
