"""The topic `life`: the state of each part of the rig, two values of each device, loads of buses, and events.

A page gets the whole first, and then what has changed.  The rig is asked only while a page looks.
"""

import asyncio
import time
from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Final

from fieldrig.control.notices import in_words as notice_in_words
from fieldrig.control.notices import taken
from fieldrig.device import POWER_OFF
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.bus_load import Reading, kept_percent, load_words
from fieldrig_page.card_values import CardValues
from fieldrig_page.changes import Changes
from fieldrig_page.live import Page
from fieldrig_page.rig_link import RigLink
from fieldrig_page.states import Level, PartState, Process, state_of_bus, state_of_device

PERIOD_S: Final = 0.5
LOAD_TICKS: Final = 4
"""Looks between two readings of the load of a bus: a rate over half a second would jump."""
MOST_EVENTS: Final = 100
NO_ANSWER: Final = PartState(Level.DOWN, "no answer", ("the rig does not answer",))


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
        self._conditions: dict[str, dict[str, str]] = {}
        self._readings: dict[str, Reading] = {}
        self._loads: dict[str, str] = {}
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
        while True:
            await self._is_wanted.wait()
            try:
                await self._look()
            except ControlError as cause:
                self._on_silence(cause)
            await asyncio.sleep(PERIOD_S)

    async def _look(self) -> None:
        link = self._link
        status, details, faults, faults_of_buses = await asyncio.gather(
            link.recent("rig/status"),
            link.recent("process/*/status"),
            link.recent("device/*/faults"),
            link.recent("bus/*/faults"),
        )
        if self._looks % LOAD_TICKS == 0:  # between them notices tell what changes
            self._conditions = await link.ask_all("bus/*/conditions")
        await self._values.look()
        processes = _processes(status, details)
        for name in link.config.devices:
            state = state_of_device(processes.get(name, Process()), faults.get(name, {}), self._values.troubles(name))
            more = {"off": _power_off(faults.get(name, {})), "kept": self._kept.get(name)}
            known = {key: value for key, value in more.items() if value is not None}
            self._put(name, state, processes.get(name), **known)
        figures = {bus: found for detail in details.values() for bus, found in detail["buses"].items()}
        self._take_loads(status.get("now_ns", time.monotonic_ns()), figures)
        for name in link.config.buses:
            conditions = self._conditions.get(name, {})
            own = figures.get(name, {})
            state = state_of_bus(processes.get(name, Process()), faults_of_buses.get(name, {}), conditions, own)
            cuts = _cuts(faults_of_buses.get(name, {}))
            self._put(
                name, state, processes.get(name), load=self._loads.get(name, ""), **({"cuts": cuts} if cuts else {})
            )

    def _put(self, name: str, state: PartState, process: Process | None, **more: Any) -> None:
        restarts = {"restarts": process.restarts} if process is not None and process.restarts else {}
        self._parts.put(name, {"level": state.level, "word": state.word, "why": list(state.why), **restarts, **more})

    def _take_loads(self, now_ns: int, figures: Mapping[str, Mapping[str, float]]) -> None:
        if self._looks % LOAD_TICKS == 0:
            readings = {bus: Reading(now_ns, own) for bus, own in figures.items()}
            self._loads = {bus: load_words(self._readings.get(bus), now) for bus, now in readings.items()}
            shares = (kept_percent(self._readings.get(bus), now) for bus, now in readings.items())
            self._kept = {name: share for of_bus in shares for name, share in of_bus.items()}
            self._readings = readings
        self._looks += 1

    def _on_silence(self, cause: ControlError) -> None:
        for name in (*self._link.config.devices, *self._link.config.buses):
            self._put(name, NO_ANSWER._replace(why=(cause.what,)), None)

    def _on_event(self, _name: str, message: Any) -> None:
        match message:
            case {"what": str(what), "process": str(process), "text": str(text), "time_s": int() | float() as time_s}:
                self._note(time_s, process, f"{what}: {text}" if text else what)

    def _on_notice(self, _name: str, message: Any) -> None:
        notice = taken(message)
        if notice is None or notice.part not in self._link.config.devices.keys() | self._link.config.buses.keys():
            return
        self._note(time.time(), notice.part, notice_in_words(notice))
        if not notice.key.startswith("fault "):
            conditions = self._conditions.setdefault(notice.part, {})
            if notice.is_over:
                conditions.pop(notice.key, None)
            else:
                conditions[notice.key] = notice.text

    def _note(self, time_s: float, part: str, text: str) -> None:
        self._event += 1
        self._events.append((self._event, {"number": self._event, "time_s": time_s, "part": part, "text": text}))


def _processes(status: Mapping[str, Any], details: Mapping[str, Any]) -> dict[str, Process]:
    """Return the process of each part by the name of the part; none in virtual time."""
    found: dict[str, Process] = {}
    for name, process in status["processes"].items():
        late = details.get(name, {}).get("late", {}).get("words", "")
        for part in (*process.get("buses", ()), *process.get("devices", ())):
            found[part] = Process(process["state"], late, process.get("restarts", 0))
    return found


def _cuts(faults: Mapping[str, Mapping[str, Any]]) -> dict[str, int]:
    """Return the number of the fault that cuts the segment of a ring behind a station, by the station."""
    return {
        str(fault["after"]): int(number)
        for number, fault in faults.items()
        if fault.get("what") == "break" and fault.get("state") == "on" and "after" in fault
    }


def _power_off(faults: Mapping[str, Mapping[str, Any]]) -> int | None:
    """Return the number of the fault that has switched a device off; None if it has power."""
    off = (
        int(number) for number, fault in faults.items() if fault.get("what") == POWER_OFF and fault.get("state") == "on"
    )
    return next(off, None)
