"""Join one bus in real time without being a device of a rig: for tools that send, listen and are gone again."""

import asyncio
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from fieldrig.attach import RemoteLink
from fieldrig.bus import Bus, DirectBus, ModelBus
from fieldrig.bus_questions import Subject
from fieldrig.clock import Clock
from fieldrig.errors import BusError
from fieldrig.link import Link
from fieldrig.real_clock import RealClock
from fieldrig.sending import CheckedLink

OnEnd = Callable[[Exception | None], None]
Start = Callable[[Clock, Link[Any], OnEnd], None]
"""Begins what the visitor does; it calls the last argument when it is done, or with what went wrong."""


def visit(bus: Bus[Any], run: Path, member: str, start: Start) -> None:
    """Join `bus` as `member`, and return when the visitor is done.  `run` is the folder of the rig that runs the bus.

    BusError, with its remedy, if the bus can't be had or goes away.
    """
    asyncio.run(_visit(bus, run, member, start))


class _Visitor:
    """An `Attachment`."""

    rig, seed = "", 0
    process: Final = "visitor"
    members: Final[Mapping[str, str]] = {}

    def __init__(self, member: str, clock: RealClock, run: Path) -> None:
        self.member, self.clock, self._run = member, clock, run

    def path(self, name: str) -> Path:
        return self._run / name

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        self.clock.handle_at(time.monotonic_ns() if instant_ns is None else instant_ns, handler, message)

    def heard(self, sender: str, message: Any) -> None:
        """A visitor keeps no trace."""

    def session(self) -> Any:
        raise BusError("this bus is carried by the control service of a rig", "name a device of the rig instead")

    def serve(self, subject: Subject) -> None:
        """A visitor answers no questions."""


async def _visit(bus: Bus[Any], run: Path, member: str, start: Start) -> None:
    loop = asyncio.get_running_loop()
    clock, done = RealClock(loop), loop.create_future()

    def on_end(fault: Exception | None) -> None:
        if not done.done():
            done.set_result(fault)

    try:
        link = await _join(bus, run, member, clock, on_end)
        try:
            clock.handle(start, clock, link, on_end)
            fault = await done
        finally:
            await (link.close() if isinstance(link, RemoteLink) else _leave(bus, member))
    finally:
        clock.close()
    if fault is not None:
        raise fault


async def _join(bus: Bus[Any], run: Path, member: str, clock: RealClock, on_end: OnEnd) -> Link[Any]:
    if isinstance(bus, DirectBus):
        return CheckedLink(await bus.open(_Visitor(member, clock, run)), bus, member)
    assert isinstance(bus, ModelBus)
    remote = RemoteLink(bus, member, clock, run, lambda reason: on_end(BusError(reason)))
    await remote.connect()
    return remote


async def _leave(bus: Bus[Any], member: str) -> None:
    assert isinstance(bus, DirectBus)
    await bus.close(member)
