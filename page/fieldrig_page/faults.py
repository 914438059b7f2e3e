"""The faults of a rig for the page: what each part can suffer, what it suffers now, and a time line of what happened.

The time line has faults and conditions of buses and devices as they begin and end (`control/notices.py`), and the
events of the rig, such as the end of a process.  It is kept for pages that come later, up to `MOST_LINES`.
"""

import asyncio
import time
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Any, ClassVar, Final

from pydantic import BaseModel, ConfigDict, Field

from fieldrig.control import events, notices
from fieldrig.control.fault_asking import Asking, about_faults
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.api import Call, Operation
from fieldrig_page.fault_kinds import kinds_of
from fieldrig_page.live import Page
from fieldrig_page.rig_link import RigLink

POLL_S: Final = 1.0
MOST_LINES: Final = 500

Fault = dict[str, Any]


class NewFault(BaseModel):
    """A fault to add; its further keys are those of `faults/kinds`, and may be texts as people type them."""

    model_config = ConfigDict(extra="allow")
    part: str = Field(description="name of a bus or device")
    what: str = Field(description="name of the fault", examples=["drop"])


class Faults:
    """The topic `faults`, and what the HTTP API asks about them."""

    name: ClassVar[str] = "faults"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._faults: list[Fault] = []
        self._version = 0
        self._lines: deque[dict[str, Any]] = deque(maxlen=MOST_LINES)
        self._next_line = 0
        self._sent: dict[Page, tuple[int, int]] = {}
        """The version of the list, and the number of the next line, that each page has."""
        self._changed = asyncio.Event()

    # ---- the topic

    def want(self, page: Page, wish: Any) -> None:
        if wish is not None and wish is not True:
            raise MalformedError("faults: expected true")
        self._sent[page] = (-1, 0)
        self._changed.set()

    def forget(self, page: Page) -> None:
        self._sent.pop(page, None)

    def frame(self, page: Page) -> dict[str, Any] | None:
        """Return the list if it has changed, and the lines that the page does not have."""
        version, next_line = self._sent[page]
        if (version, next_line) == (self._version, self._next_line):
            return None
        self._sent[page] = (self._version, self._next_line)
        frame: dict[str, Any] = {"lines": [line for line in self._lines if line["number"] >= next_line]}
        if next_line == 0:
            frame["whole"] = True
        if version != self._version:
            frame["faults"] = self._faults
        return frame

    async def run(self) -> None:
        self._link.listen_to("notice/*", self._on_notice)
        self._link.listen_to("event", self._on_event)
        while True:
            self._changed.clear()  # before the look, so that a page that comes meanwhile is seen at once
            if self._sent:
                await self._look()
            try:
                async with asyncio.timeout(POLL_S):
                    await self._changed.wait()
            except TimeoutError:
                continue

    async def _look(self) -> None:
        try:
            found = await self.active()
        except ControlError:  # the rig is being stopped or restarted
            return
        if found != self._faults:
            self._faults = found
            self._version += 1

    def _on_notice(self, _name: str, message: Any) -> None:
        notice = notices.taken(message)
        if notice is None:
            return
        kind = "fault" if notice.key.startswith(notices.FAULT) else "condition"
        self._add(notice.part, kind, notice.key if kind == "fault" else "", notice.text, is_over=notice.is_over)
        self._changed.set()

    def _on_event(self, _name: str, message: Any) -> None:
        event = events.taken(message)
        if event is not None:
            self._add(event.process, "event", "", events.in_words(event), is_over=False)

    def _add(self, part: str, kind: str, key: str, text: str, *, is_over: bool) -> None:
        line = {"part": part, "kind": kind, "key": key, "text": text, "is_over": is_over}
        self._lines.append({"number": self._next_line, "time_ns": time.time_ns(), **line})
        self._next_line += 1

    # ---- what the HTTP API asks

    async def active(self) -> list[Fault]:
        """Return the faults that were given and not cleared, each with its part and number."""
        by_part = {**await self._link.ask_all("bus/*/faults"), **await self._link.ask_all("device/*/faults")}
        for name, entry in self._link.config.buses.items():
            if name not in by_part and entry.bus.fault_models:
                try:
                    by_part[name] = await self._ask(about_faults(name, "faults", None))
                except ControlError:  # no end of it takes faults, or its process has not started
                    continue
        order = [*self._link.config.buses, *self._link.config.devices]
        return [
            {"part": part, "number": int(number), **fault}
            for part in sorted(by_part, key=order.index)
            for number, fault in by_part[part].items()
        ]

    async def add(self, part: str, fault: Mapping[str, Any]) -> int:
        """Add a fault and return its number.  ControlError if the part refuses it, or does not exist."""
        answer = await self._ask(about_faults(part, "add_fault", {"fault": dict(fault)}))
        self._changed.set()
        return int(answer["number"])

    async def clear(self, part: str, number: int | None) -> list[int]:
        """Clear a fault of a part, or all of them, and return their numbers."""
        answer = await self._ask(about_faults(part, "clear_fault", {"number": number}))
        self._changed.set()
        return [int(cleared) for cleared in answer["cleared"]]

    async def _ask(self, asking: Asking) -> Any:
        try:
            question = next(asking)
            while True:
                try:
                    ask = self._link.ask_all if question.of_all else self._link.ask
                    answer = await (ask(question.path) if question.of_all else ask(question.path, question.message))
                except ControlError as refusal:
                    question = asking.throw(refusal)
                else:
                    question = asking.send(answer)
        except StopIteration as end:
            return end.value

    def operations(self) -> Iterator[Operation]:
        """Yield the operations on faults."""

        async def active(_call: Call) -> list[Fault]:
            return await self.active()

        async def kinds(_call: Call) -> dict[str, Any]:
            return kinds_of(self._link.config)

        async def add(call: Call) -> dict[str, int]:
            new: NewFault = call.body
            return {"number": await self.add(new.part, {"what": new.what, **(new.model_extra or {})})}

        async def clear(call: Call) -> dict[str, list[int]]:
            number = call.path["number"]
            if number != "all" and not number.isdecimal():
                raise ValueError(f"expected the number of a fault or all, found {number!r:.40}")
            return {"cleared": await self.clear(call.path["part"], None if number == "all" else int(number))}

        part = {"part": "name of a bus or device"}
        yield Operation("GET", "faults", "Return the faults that were not cleared.", active, gives=list[Fault])
        yield Operation("GET", "faults/kinds", "Return what each part can suffer, as JSON schemas.", kinds)
        yield Operation("POST", "faults", "Add a fault, and return its number.", add, NewFault, dict[str, int])
        yield Operation(
            "DELETE", "faults/{part}/{number}", "Clear a fault.", clear, gives=dict[str, list[int]],
            parameters={**part, "number": "number of the fault, or all"},
        )  # fmt: skip
