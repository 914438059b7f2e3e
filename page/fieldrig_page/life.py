"""The topic `life`: the state of each part of the rig, two values of each device, loads of buses, and events.

A page gets the whole first, and then what has changed.  The rig is asked only while a page looks.
"""

import asyncio
import time
from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from fieldrig.control import events
from fieldrig.control.notices import FAULT, taken
from fieldrig.control.notices import in_words as notice_in_words
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.bus_load import Reading, kept_percent, load_words, numbers_of
from fieldrig_page.card_values import CardValues
from fieldrig_page.changes import Changes
from fieldrig_page.live import Page
from fieldrig_page.part_faults import Faults, cuts, faults_of, is_active, power_off
from fieldrig_page.rig_link import RigLink
from fieldrig_page.states import NO_ANSWER, Level, PartState, Process, state_of_bus, state_of_device

PERIOD_S: Final = 0.5
LOAD_LOOKS: Final = 4
"""Looks between two readings of the load of a bus: a rate over half a second would jump."""
WHOLE_LOOKS: Final = 20
"""Looks after which every part is asked for its faults."""
MOST_EVENTS: Final = 100
AWAY: Final = PartState(Level.DOWN, NO_ANSWER, ("the rig does not answer",))
SILENT_LOOKS: Final = 2
"""Readings in a row without the load of a bus that had one, after which it is silent."""


@dataclass
class _Sent:
    """How far a page has come."""

    is_whole: bool = False
    part: int = 0
    value: int = 0
    sample: int = 0
    event: int = 0


class Life:
    name: ClassVar[str] = "life"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._values = CardValues(link)
        self._parts: Changes[dict[str, Any]] = Changes()
        self._events: deque[tuple[int, dict[str, Any]]] = deque(maxlen=MOST_EVENTS)
        self._event = 0
        self._faults: dict[str, Faults] = {}
        self._changed: set[str] = set()
        """Parts of which a fault has begun."""
        self._conditions: dict[str, dict[str, str]] = {}
        self._readings: dict[str, Reading] = {}
        self._loads: dict[str, str] = {}
        self._unheard: Counter[str] = Counter()
        """Readings in a row that each bus which had a load is missing in."""
        self._kept: dict[str, int] = {}
        self._looks = 0
        self._sent: dict[Page, _Sent] = {}
        self._is_wanted = asyncio.Event()

    def want(self, page: Page, wish: Any) -> None:
        if wish is not True:
            raise MalformedError("expected true for the topic life")
        self._sent[page] = _Sent()
        self._is_wanted.set()

    def forget(self, page: Page) -> None:
        self._sent.pop(page, None)
        if not self._sent:
            self._is_wanted.clear()

    def frame(self, page: Page) -> dict[str, Any] | None:
        sent = self._sent[page]
        if not self._parts.number:  # nothing is known yet
            return None
        news = {
            "parts": self._parts.since(sent.part),
            "values": self._values.shown.since(sent.value),
            "samples": self._values.samples_since(sent.sample),
            "events": [event for number, event in self._events if number > sent.event],
        }
        if sent.is_whole and not any(news.values()):
            return None
        frame = {"whole": not sent.is_whole, **{key: new for key, new in news.items() if new}}
        self._sent[page] = _Sent(True, self._parts.number, self._values.shown.number, self._values.sample, self._event)
        return frame

    async def run(self) -> None:
        self._link.listen_to("event", self._on_event)
        self._link.listen_to("notice/*", self._on_notice)
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self._values.run(self._is_wanted))
            tasks.create_task(self._watch())

    async def _watch(self) -> None:
        while True:
            await self._is_wanted.wait()
            try:
                await self._look()
            except ControlError as cause:
                self._on_silence(cause)
            await asyncio.sleep(PERIOD_S)

    async def _look(self) -> None:
        """Look at the rig: often at what one question tells, and seldom at each of its processes."""
        status = await self._link.recent("rig/status")
        if self._looks % WHOLE_LOOKS == 0:
            await self._ask_all()
        await self._ask_changed()
        if self._looks % LOAD_LOOKS == 0:
            status = await self._link.ask("rig/status")  # at the same instant, for rates
            self._take_loads(status.get("now_ns", time.monotonic_ns()), await self._link.ask_all("bus/*/status"))
        self._looks += 1
        self._tell(_processes(status))

    async def _ask_all(self) -> None:
        """Ask every part for what notices tell otherwise, so that a notice that was lost is made good."""
        given = await self._link.ask_all("device/*/faults") | await self._link.ask_all("bus/*/faults")
        self._faults = {name: faults_of(answer) for name, answer in given.items()}
        self._conditions = await self._link.ask_all("bus/*/conditions")

    async def _ask_changed(self) -> None:
        """Ask the parts with faults, and those of which one has begun: a notice can miss one that is short."""
        faulty = {name for name, faults in self._faults.items() if any(map(is_active, faults.values()))}
        changed, self._changed = self._changed | faulty, set()
        for name in sorted(changed):
            sort = "bus" if name in self._link.config.buses else "device"
            try:
                self._faults[name] = faults_of(await self._link.ask(f"{sort}/{name}/faults"))
            except ControlError:  # its process has ended, and its faults with it
                self._faults.pop(name, None)

    def _tell(self, processes: Mapping[str, Process]) -> None:
        for name in self._link.config.devices:
            faults = self._faults.get(name, {})
            process = processes.get(name, Process())._replace(is_silent=self._values.is_silent(name))
            state = state_of_device(process, faults, self._values.troubles(name))
            self._put(name, state, processes.get(name), off=power_off(faults), kept=self._kept.get(name))
        for name in self._link.config.buses:
            faults, reading = self._faults.get(name, {}), self._readings.get(name)
            figures = {} if reading is None else reading.figures
            process = processes.get(name, Process())._replace(is_silent=self._unheard[name] >= SILENT_LOOKS)
            state = state_of_bus(process, faults, self._conditions.get(name, {}), figures)
            self._put(name, state, processes.get(name), load=self._loads.get(name), cuts=cuts(faults) or None)

    def _put(self, name: str, state: PartState, process: Process | None, **more: Any) -> None:
        restarts = None if process is None else process.restarts or None
        facts = {"level": state.level, "word": state.word, "why": list(state.why), "restarts": restarts, **more}
        self._parts.put(name, {key: value for key, value in facts.items() if value is not None})

    def _take_loads(self, now_ns: int, figures: Mapping[str, Any]) -> None:
        readings = {bus: Reading(now_ns, numbers_of(own)) for bus, own in figures.items()}
        self._loads = {bus: load_words(self._readings.get(bus), now) for bus, now in readings.items()}
        shares = (kept_percent(self._readings.get(bus), now) for bus, now in readings.items())
        self._kept = {name: share for of_bus in shares for name, share in of_bus.items()}
        for bus in self._unheard.keys() | readings.keys():
            self._unheard[bus] = 0 if bus in readings else self._unheard[bus] + 1
        self._readings = readings

    def _on_silence(self, cause: ControlError) -> None:
        for name in (*self._link.config.devices, *self._link.config.buses):
            self._put(name, AWAY._replace(why=(cause.what,)), None)

    def _on_event(self, _name: str, message: Any) -> None:
        event = events.taken(message)
        if event is not None:
            self._note(event.time_s, event.process, events.in_words(event))

    def _on_notice(self, _name: str, message: Any) -> None:
        notice = taken(message)
        if notice is None or notice.part not in self._link.config.devices.keys() | self._link.config.buses.keys():
            return
        self._note(time.time(), notice.part, notice_in_words(notice))
        if notice.key.startswith(FAULT):
            self._changed.add(notice.part)
        else:
            conditions = self._conditions.setdefault(notice.part, {})
            conditions.pop(notice.key, None)
            if not notice.is_over:
                conditions[notice.key] = notice.text

    def _note(self, time_s: float, part: str, text: str) -> None:
        self._event += 1
        self._events.append((self._event, {"number": self._event, "time_s": time_s, "part": part, "text": text}))


def _processes(status: Mapping[str, Any]) -> dict[str, Process]:
    """Return the process of each part by the name of the part."""
    found: dict[str, Process] = {}
    for name, process in status["processes"].items():
        late = status.get("late", {}).get(name, "")
        for part in (*process.get("buses", ()), *process.get("devices", ())):
            found[part] = Process(process["state"], late, process.get("restarts", 0))
    return found
