"""The topic `rig`: whether the rig runs, its time, and its processes, for the head of the page."""

import asyncio
from typing import Any, ClassVar, Final

from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError
from fieldrig_page.live import Page
from fieldrig_page.rig_link import RigLink

PERIOD_S: Final = 0.5
DETAIL_LOOKS: Final = 10
"""Looks after which each process is asked for its figures: it reads its memory for them, which takes milliseconds."""
SHOWN: Final = ("state", "time", "uptime_s", "now_ns", "speed", "late", "prelude")


class RigState:
    """The state of the rig, asked for while a page wants it."""

    name: ClassVar[str] = "rig"

    def __init__(self, link: RigLink) -> None:
        self._link = link
        self._sent: dict[Page, dict[str, Any] | None] = {}
        self._state: dict[str, Any] = {}
        self._is_wanted = asyncio.Event()

    def want(self, page: Page, wish: Any) -> None:
        if wish is not True:
            raise MalformedError("expected true as the request for the rig")
        self._sent[page] = None
        self._is_wanted.set()

    def forget(self, page: Page) -> None:
        self._sent.pop(page, None)
        if not self._sent:
            self._is_wanted.clear()

    def frame(self, page: Page) -> dict[str, Any] | None:
        if not self._state or self._sent[page] is self._state:
            return None
        self._sent[page] = self._state
        return self._state

    async def run(self) -> None:
        looks, processes = 0, dict[str, Any]()
        while True:
            await self._is_wanted.wait()
            try:
                status = await self._link.recent("rig/status")
                if looks % DETAIL_LOOKS == 0:
                    processes = await self._link.recent("process/*/brief")
                looks += 1
            except ControlError as cause:
                self._state = {"state": "away", "why": cause.what}
            else:
                self._state = {key: status[key] for key in SHOWN if key in status}
                self._state["processes"] = _processes(status, processes)
            await asyncio.sleep(PERIOD_S)


def _processes(status: dict[str, Any], details: dict[str, Any]) -> dict[str, Any]:
    """Return what each process runs, its state and its figures, by name."""
    known = {name: dict(process) for name, process in status["processes"].items()}
    for name, detail in details.items():
        known.setdefault(name, {"state": "ready"}).update(
            {key: detail[key] for key in ("memory_mb", "cpu_s", "late") if key in detail}
        )
    return known
