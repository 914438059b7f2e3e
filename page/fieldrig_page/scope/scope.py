"""The topic `scope`: several pages beside each other, each with its own set-up, on recordings that they share."""

import asyncio
import time
from collections.abc import Callable, Iterator
from typing import Any, ClassVar, Final

from fieldrig.recording.reader import Reader
from fieldrig.traces.names import namer_of
from fieldrig.traces.trace import is_batch
from fieldrig_page.api import Operation
from fieldrig_page.bus_record import BusRecord
from fieldrig_page.live import Page
from fieldrig_page.rig_link import RigLink
from fieldrig_page.scope.captures import Captures
from fieldrig_page.scope.events import Event, Events
from fieldrig_page.scope.operations import operations
from fieldrig_page.scope.recordings import MakeReader, Recordings
from fieldrig_page.scope.session import Session, read_wish
from fieldrig_page.scope.setups import Setups
from fieldrig_page.scope.store import Track
from fieldrig_page.scope.triggers import Hit

TICK_S: Final = 0.1


class Scope:
    name: ClassVar[str] = "scope"

    def __init__(self, link: RigLink, make_reader: MakeReader | None = None) -> None:
        self.link = link
        self.recordings = Recordings(make_reader or self._reader)
        self.captures = Captures()
        self.setups = Setups(link.config.run)
        self.origin_ns = 0 if link.config.time == "virtual" else time.monotonic_ns()
        self.events = Events(self.now_ns)
        self._sessions: dict[object, Session] = {}
        self._told: dict[object, int] = {}
        """How many events each page has."""
        self._ends: dict[str, Callable[[], None]] = {}
        """Each ends a subscription, by its path."""
        self._records: dict[str, BusRecord] = {}
        """The messages of buses that triggers wait for."""
        self._newest_ns = self.origin_ns
        self.recordings.on_rows.append(self._on_rows)
        self.recordings.on_progress.append(self._on_progress)
        self.events.on_event.append(self._on_event)

    def now_ns(self) -> int:
        """The present instant of the rig, as far as it is known here."""
        return self._newest_ns if self.link.config.time == "virtual" else time.monotonic_ns()

    def want(self, page: Page, wish: Any) -> None:
        checked = read_wish(wish)
        self._told[page] = 0
        self.session(page).want(checked)
        self._listen()

    def forget(self, page: Page) -> None:
        self._told.pop(page, None)
        self.end(page)

    def frame(self, page: Page) -> Any | None:
        session = self._sessions.get(page)
        frame = session.frame() if session is not None else None
        told = self._told.get(page, 0)
        if told < self.events.count or (frame is not None and frame.get("whole")):
            events = self.events.since(0 if frame is not None and frame.get("whole") else told)
            self._told[page] = self.events.count
            frame = {**(frame or {}), "events": [self._shown(event) for event in events]}
        return frame

    async def run(self) -> None:
        self._ends["notice"] = self.link.listen_to("notice/*", self.events.take_notice)
        self._ends["event"] = self.link.listen_to("event", self.events.take_event)
        try:
            while True:  # pictures that wait for a process that has fallen silent
                await asyncio.sleep(TICK_S)
                self._on_progress()
        finally:
            for end in self._ends.values():
                end()
            await self.recordings.close()

    def operations(self) -> Iterator[Operation]:
        """Yield the operations of the HTTP API."""
        return operations(self)

    def session(self, user: object) -> Session:
        """The scope of a page, or of another user such as a call of the HTTP API."""
        if user not in self._sessions:
            self._sessions[user] = Session(self.recordings, self.captures, self.origin_ns, time.monotonic, user)
        return self._sessions[user]

    def end(self, user: object) -> None:
        session = self._sessions.pop(user, None)
        if session is not None:
            session.forget()
            self._listen()

    def listen(self) -> None:
        """Hear the messages of the buses that triggers wait for, and of no others."""
        self._listen()

    def _reader(self, signals: Any, rhythm: Any, on_rows: Any, on_complete: Any) -> Reader:
        return Reader(self.link.control, signals, rhythm, on_rows, on_complete)

    def _on_rows(self, track: Track, first: int) -> None:
        if first == track.base:  # it begins, or it begins again in a rig that went back
            self._newest_ns = track.known_ns
        self._newest_ns = max(self._newest_ns, track.known_ns)
        for session in tuple(self._sessions.values()):
            session.on_rows(track, first)

    def _on_progress(self) -> None:
        for session in tuple(self._sessions.values()):
            session.tick()

    def _on_event(self, event: Event) -> None:
        for session in tuple(self._sessions.values()):
            trigger = session.trigger
            if event.sort == "fault" and trigger is not None and trigger.fits_fault(event.part, event.is_over):
                session.strike(Hit(0, event.at_ns, event.after_ns))

    def _listen(self) -> None:
        triggers = [session.trigger for session in self._sessions.values()]
        parts = {trigger.part for trigger in triggers if trigger is not None and trigger.kind == "message"}
        wanted = parts & self.link.config.buses.keys()
        for bus in self._records.keys() - wanted:
            self._ends.pop(f"trace/{bus}")()
            del self._records[bus]
        for bus in wanted - self._records.keys():
            self._records[bus] = BusRecord(self.link.config.buses[bus].bus, namer_of(self.link.config, bus))
            self._ends[f"trace/{bus}"] = self.link.listen_to(f"trace/{bus}", self._on_messages)

    def _on_messages(self, bus: str, batch: Any) -> None:
        if not is_batch(batch) or bus not in self._records:
            return
        record = self._records[bus]
        next_before, lost_before = record.next, record.lost
        record.take(batch)
        texts = [(row.message.time_ns, row.searched) for row in record.rows(next_before, record.next - next_before)]
        for session in tuple(self._sessions.values()):
            trigger = session.trigger
            if trigger is None or trigger.kind != "message" or trigger.part != bus:
                continue
            session.messages_lost += record.lost - lost_before
            for time_ns, text in texts:
                if trigger.fits_message(bus, text):
                    instant_ns = time_ns - batch["epoch_ns"]
                    session.strike(Hit(0, instant_ns, instant_ns))

    def _shown(self, event: Event) -> dict[str, Any]:
        shown = event._asdict()
        return shown | {"after_ns": event.after_ns - self.origin_ns, "at_ns": event.at_ns - self.origin_ns}
