"""A member of buses in real time for a tool without an event loop: it sends, and drives wires, until it is closed."""

import asyncio
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from threading import Event, Thread
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.clock import Clock
from fieldrig.errors import BusError, ControlError
from fieldrig.hub.tool_member import OnEnd, join_all
from fieldrig.link import Link

JOIN_S: Final = 10.0
"""The longest time until it has joined the buses."""


class ThreadMember:
    """Joins buses in a thread of its own, until it is closed."""

    def __init__(self, buses: Sequence[Bus[Any]], run: Path, name: str) -> None:
        """ControlError if a bus cannot be joined."""
        self._ready, self._wrong = Event(), list[BusError]()
        self._thread = Thread(target=self._work, args=(list(buses), run, name), name="member", daemon=True)
        self._thread.start()
        self._ready.wait(JOIN_S)
        self._check()

    def send(self, bus: str, message: Any) -> None:
        """Send a message, and return when it has been handed to its bus."""
        self._check()
        sent = asyncio.run_coroutine_threadsafe(self._send(bus, message), self._loop)
        sent.result(JOIN_S)

    def close(self) -> None:
        if self._thread.is_alive():
            self._loop.call_soon_threadsafe(self._end, None)
            self._thread.join(JOIN_S)

    async def _send(self, bus: str, message: Any) -> None:
        self._clock.handle(self._links[bus].send, message)

    def _check(self) -> None:
        if self._wrong:
            raise ControlError(self._wrong[0].what, self._wrong[0].remedy)

    def _work(self, buses: Sequence[Bus[Any]], run: Path, name: str) -> None:
        try:
            join_all(buses, run, name, self._start)
        except BusError as wrong:
            self._wrong.append(wrong)
        finally:
            self._ready.set()

    def _start(self, clock: Clock, links: Mapping[str, Link[Any]], on_end: OnEnd) -> None:
        self._loop, self._links = asyncio.get_running_loop(), links
        self._clock: Any = clock
        self._end: Callable[[Exception | None], None] = on_end
        self._ready.set()
