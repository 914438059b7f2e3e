"""Join buses in real time without being a device of a rig: for tools that send and listen for a while."""

import asyncio
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import AsyncExitStack
from functools import partial
from pathlib import Path
from typing import Any, Final

from fieldrig.bus import Bus, DirectBus, ModelBus
from fieldrig.clock import Clock
from fieldrig.control.subject import WaitingSubject
from fieldrig.errors import BusError
from fieldrig.hub.attach import RemoteLink
from fieldrig.hub.checked_link import CheckedLink
from fieldrig.link import Link
from fieldrig.loop.real_clock import RealClock

OnEnd = Callable[[Exception | None], None]
Start = Callable[[Clock, Link[Any], OnEnd], None]
"""Starts the tool's work.  The work calls the last argument when it is done, with the exception if it failed."""
StartAll = Callable[[Clock, Mapping[str, Link[Any]], OnEnd], None]
"""The same with an end of several buses, by name."""


def join(bus: Bus[Any], run: Path, member: str, start: Start) -> None:
    """Join `bus` as `member`, and return when the work is done.  `run` is the run folder of the rig with the bus.

    BusError, with its remedy, if the bus is not available or goes away.
    """
    join_all([bus], run, member, lambda clock, links, on_end: start(clock, links[bus.name], on_end))


def join_all(buses: Sequence[Bus[Any]], run: Path, member: str, start: StartAll) -> None:
    """Join several buses of one rig as `join` does, with one clock for all of them."""
    asyncio.run(_work(buses, run, member, start))


class _ToolAttachment:
    """The `Attachment` of a tool to a direct bus."""

    rig, seed = "", 0
    process: Final = "tool"
    members: Final[Mapping[str, str]] = {}

    def __init__(self, member: str, clock: RealClock, run: Path) -> None:
        self.member, self.clock, self._run = member, clock, run

    def path(self, name: str) -> Path:
        return self._run / name

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        self.clock.handle_at(time.monotonic_ns() if instant_ns is None else instant_ns, handler, message)

    def heard(self, sender: str, message: Any) -> None:
        """Do nothing, as a tool keeps no trace."""

    def note_late(self, late_ns: int) -> None:
        """Do nothing, as a tool keeps no log."""

    def session(self) -> Any:
        raise BusError("this bus is carried by the control service of a rig", "name a device of the rig instead")

    def serve(self, subject: WaitingSubject) -> None:
        """Do nothing, as a tool answers no questions."""


async def _work(buses: Sequence[Bus[Any]], run: Path, member: str, start: StartAll) -> None:
    loop = asyncio.get_running_loop()
    clock, done = RealClock(loop), loop.create_future()

    def on_end(fault: Exception | None) -> None:
        if not done.done():
            done.set_result(fault)

    async with AsyncExitStack() as opened:
        opened.callback(clock.close)
        links = {}
        for bus in buses:
            links[bus.name] = link = await _opened(bus, run, member, clock, on_end)
            opened.push_async_callback(link.close if isinstance(link, RemoteLink) else partial(_leave, bus, member))
        clock.handle(start, clock, links, on_end)
        fault = await done
    if fault is not None:
        raise fault


async def _opened(bus: Bus[Any], run: Path, member: str, clock: RealClock, on_end: OnEnd) -> Link[Any]:
    if isinstance(bus, DirectBus):
        return CheckedLink(await bus.open(_ToolAttachment(member, clock, run)), bus, member)
    assert isinstance(bus, ModelBus)
    remote = RemoteLink(bus, member, clock, run, lambda reason: on_end(BusError(reason)))
    await remote.connect()
    return remote


async def _leave(bus: Bus[Any], member: str) -> None:
    assert isinstance(bus, DirectBus)
    await bus.close(member)
