"""All changes that a scenario wants to know of a rig in real time, in the order of their instants.

Points are recorded in the processes of their devices, and messages are published by their buses; both come in batches.
An instant is judged when everything up to it is known.
"""

from bisect import insort
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from math import isnan
from typing import Final

from fieldrig.clock import MS, S
from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.points.values import counted
from fieldrig.real.bus_inbox import BusInbox
from fieldrig.real.running_rig import RunningRig
from fieldrig.recording.recording import LiveRecording
from fieldrig.recording.signals import CHANGE, Rhythm, Sort
from fieldrig_devices.scenarios.live_places import LivePlaces
from fieldrig_devices.scenarios.live_traffic import Change, Traffic
from fieldrig_devices.scenarios.tracing import Trace

BEHIND_NS: Final = 250 * MS
"""The time that messages have to come: they are published every 20 ms."""
PERIOD_NS: Final = 10 * MS
"""The time between two looks at numbers, which may change without an event."""
LOOK_NS: Final = 1 * MS
"""The time between two looks at the age of a message."""
MOST_PENDING: Final = 200_000
"""Changes that wait to be judged."""


class LiveEvents(ExitStack):
    """Changes of the places of a scenario."""

    def __init__(self, rig: RunningRig, config: RigConfig, places: LivePlaces, trace: Trace | None = None) -> None:
        """Listen from now on; `trace` takes the messages of all buses."""
        super().__init__()
        self._rig, self._places, self._trace = rig, places, trace
        self._traffic = Traffic(config, places.calls, list(places.signals))
        self._inbox = self._opened(rig, self._traffic.buses if trace is None else list(config.buses))
        self._recordings = self._recorded(rig)
        self._taken = dict.fromkeys(((one, name) for one in self._recordings for name in places.points), 0)
        self._pending: list[tuple[int, int, str, Value]] = []
        """Changes that are not judged, with the number of their arrival."""
        self._news: list[Change] = []
        self._number = self.late = self._begin_ns = self._dropped = 0
        self.values: dict[str, Value] = {**places.values(), **self._traffic.first()}
        """The values of all places at the begin; of the last instant that was handed out later."""
        self._points = dict(places.points)
        self._latest = dict(places.points)
        """The same as of the latest news, which are not judged yet."""
        self._ages: dict[str, int] = {}
        self.judged_ns = 0
        """The instant up to which everything has been handed out."""

    def begin(self) -> int:
        """Begin now, and return the instant."""
        self._collect()
        self._pending.clear()
        self._news.clear()
        self.judged_ns = self._begin_ns = self._rig.now_ns()
        self._ages = {str(call): self.judged_ns for call in self._places.calls if call.kind == "since"}
        return self.judged_ns

    @property
    def missed(self) -> int:
        """The number of messages and changes that were lost on the way, so that nothing was judged by them."""
        return self._dropped + (0 if self._inbox is None else self._inbox.missed(self._traffic.buses))

    def notes(self, end_ns: int) -> Iterator[str]:
        """Yield sentences on what was not judged up to an instant."""
        unsampled = sum(one.lost for one in self._recordings)
        if unsampled:
            yield f"{counted(unsampled, 'sample')} of points were lost, and not judged: this host is too slow"
        if self.late:
            yield f"{counted(self.late, 'change')} came too late to be judged in order"
        if self.judged_ns < end_ns:
            yield f"nothing is known of the last {(end_ns - self.judged_ns) / MS:.0f} ms"

    def instants(self) -> Iterator[tuple[int, Mapping[str, Sequence[Value]]]]:
        """Yield each instant that is known completely, with the changes of places in their order."""
        horizon_ns = self._horizon_ns()  # first, as what is complete by then is there to be collected
        self._collect()
        while self._pending and self._pending[0][0] <= horizon_ns:
            at_ns = self._pending[0][0]
            yield from self._looks(at_ns)
            changes: dict[str, list[Value]] = {}
            while self._pending and self._pending[0][0] == at_ns:
                _, _, name, value = self._pending.pop(0)
                for place, new in self._changed(at_ns, name, value):
                    changes.setdefault(place, []).append(new)
            self.judged_ns = at_ns
            yield at_ns, changes
        if horizon_ns > self.judged_ns:
            yield from self._looks(horizon_ns)
            self.judged_ns = horizon_ns
            yield horizon_ns, self._aged(horizon_ns)

    def news(self) -> Iterator[Change]:
        """Yield all changes that have come since the last call, as soon as they have."""
        news, self._news = self._news, []
        for at_ns, name, value in news:
            yield at_ns, name, value
            yield from ((at_ns, place, shown) for place, shown in self._derived(self._latest, name, value))

    def _horizon_ns(self) -> int:
        now_ns = self._rig.now_ns()
        complete = [one.complete_ns for one in self._recordings]
        return min([*complete, now_ns - (BEHIND_NS if self._inbox is not None else LOOK_NS)])

    def _looks(self, until_ns: int) -> Iterator[tuple[int, Mapping[str, Sequence[Value]]]]:
        """Yield looks at the ages of messages before an instant, once in a millisecond."""
        if self._ages:
            for at_ns in range(self.judged_ns + LOOK_NS, until_ns, LOOK_NS):
                yield at_ns, self._aged(at_ns)

    def _aged(self, at_ns: int) -> dict[str, list[Value]]:
        return {name: [(at_ns - last_ns) / S] for name, last_ns in self._ages.items()}

    def _changed(self, at_ns: int, name: str, value: Value) -> Iterator[tuple[str, Value]]:
        """Yield the places that a change concerns, with their new values."""
        if name in self._ages:
            self._ages[name] = at_ns
        yield from self._derived(self._points, name, value)
        if name in self.values:
            yield name, value

    def _derived(self, points: dict[str, Value], name: str, value: Value) -> Iterator[tuple[str, Value]]:
        """Yield the diagnoses that a change of a point concerns, and keep its value among the points."""
        if name in points:
            points[name] = value
            for place, one in self._places.derived.items():
                if name in one.points:
                    yield place, one.value(points)

    def _collect(self) -> None:
        """Take what has come."""
        for recording in self._recordings:
            self._take_rows(recording)
        for batch in self._inbox.batches() if self._inbox is not None else ():
            if self._trace is not None:
                self._trace.take(batch.bus, batch.content)
            for change in self._traffic.changes(batch):
                self._add(*change)

    def _take_rows(self, recording: LiveRecording) -> None:
        times_ns, values = recording.times_ns, recording.values
        for column in recording.columns:
            name, is_text = column.name, column.kind is Sort.TEXT
            first = self._taken[recording, name]
            self._taken[recording, name] = end = len(times_ns[name])
            for place in range(first, end):
                number = values[name][place]
                if not isnan(number):  # its device has no power
                    known = self._places.points[name]
                    self._add(
                        times_ns[name][place], name, column.states[int(number)] if is_text else _like(known, number)
                    )

    def _add(self, at_ns: int, name: str, value: Value) -> None:
        self.late += self._begin_ns <= at_ns < self.judged_ns
        self._news.append((at_ns, name, value))
        if len(self._pending) >= MOST_PENDING:  # a process says no more up to when its changes are complete
            self._dropped += 1
            return
        self._number += 1
        insort(self._pending, (max(at_ns, self.judged_ns), self._number, name, value))

    def _opened(self, rig: RunningRig, buses: list[str]) -> BusInbox | None:
        if not buses:
            return None
        inbox = BusInbox(rig.endpoint, buses)
        self.callback(inbox.close)
        return inbox

    def _recorded(self, rig: RunningRig) -> list[LiveRecording]:
        name, points = rig.status()["rig"], self._places.points
        numbers = [point for point, value in points.items() if not isinstance(value, str | bool)]
        wanted: list[tuple[list[str], Rhythm]] = [(list(points), CHANGE), (numbers, PERIOD_NS)]
        return [self.enter_context(LiveRecording(rig.endpoint, name, each, rhythm)) for each, rhythm in wanted if each]


def _like(known: Value, number: float) -> Value:
    """Return a recorded number as a value of the sort that the point has."""
    if isinstance(known, bool):
        return bool(number)
    return int(number) if isinstance(known, int) and number.is_integer() else number
