"""An end of one bus of a rig that runs in real time, for a program of a user without an event loop.

The rig is the one at the control endpoint.  The end runs in a thread of its own; any thread may call `send` and
`receive`.
"""

import asyncio
import itertools
import os
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import Any, Final, Generic, TypeVar

from fieldrig.bus import Bus
from fieldrig.clock import Clock
from fieldrig.config.rig_file import load
from fieldrig.control.messages import Client
from fieldrig.errors import BusError, RigError
from fieldrig.hub.tool_member import OnEnd, join
from fieldrig.link import Link
from fieldrig.outside.addresses import DEFAULT_ENDPOINT, ENDPOINT_VARIABLE
from fieldrig.text.nearest import closest

M = TypeVar("M")

_numbers: Final = itertools.count(1)


class ProgramEnd(Generic[M]):
    """An end that has joined the bus.  Close it, or its thread goes on with the process."""

    def __init__(
        self,
        bus: str,
        family: str,
        prefix: str,
        interest: Sequence[object] | None = None,
        is_wanted: Callable[[Any], bool] = lambda _: True,
    ) -> None:
        """Join a bus of this name and family as `prefix:` with a number that no other end has.

        Messages for which `is_wanted` is false are dropped.  RigError, with its remedy, if there is no such bus.
        """
        self._bus, run = _bus_of_rig(bus, family)
        self._interest, self._is_wanted = interest, is_wanted
        self._arrived: SimpleQueue[tuple[int, M] | None] = SimpleQueue()
        self._loop: asyncio.AbstractEventLoop | None = None
        self._fault: Exception | None = None
        self._is_ready = threading.Event()
        member = f"{prefix}:{os.getpid()}.{next(_numbers)}"
        self._thread = threading.Thread(target=self._work, args=(run, member), name=f"fieldrig {bus}", daemon=True)
        self._thread.start()
        self._is_ready.wait()
        self._check()

    def send(self, message: M) -> None:
        """Send now.  TypeError or ValueError for a message that the bus cannot carry; BusError if the bus is gone."""
        self._bus.check(message)
        self._check()
        assert self._loop is not None
        self._loop.call_soon_threadsafe(self._link.send, message)

    def receive(self, timeout_s: float | None) -> tuple[int, M] | None:
        """Return the next message with its instant in ns (Unix); None after the time-out.

        BusError if the bus is gone.
        """
        try:
            found = self._arrived.get(timeout=timeout_s) if timeout_s != 0 else self._arrived.get_nowait()
        except Empty:
            return None
        if found is None:
            self._arrived.put(None)  # for the next call
            self._check()
        return found

    def close(self) -> None:
        """Leave the bus; what was sent before still goes out."""
        if self._thread.is_alive() and self._loop is not None:
            self._loop.call_soon_threadsafe(self._end, None)
            self._thread.join()

    def _work(self, run: Path, member: str) -> None:
        try:
            join(self._bus, run, member, self._start)
        except RigError as cause:
            self._fault = cause
        finally:
            self._arrived.put(None)
            self._is_ready.set()

    def _start(self, clock: Clock, link: Link[Any], end: OnEnd) -> None:
        self._loop, self._link, self._end = asyncio.get_running_loop(), link, end
        unix_ns = time.time_ns() - time.monotonic_ns()

        def on_message(message: Any) -> None:
            if self._is_wanted(message):
                self._arrived.put((unix_ns + clock.now_ns(), message))

        link.on_receive(on_message, self._interest)
        self._is_ready.set()

    def _check(self) -> None:
        if self._fault is not None:
            raise self._fault
        if not self._thread.is_alive():
            raise BusError("this end of the bus is closed", "join the bus again")


def joinable(family: str) -> list[str]:
    """Return the buses of this family that a program may join, in the rig at the control endpoint; none without one."""
    try:
        status = _status()
        if status["time"] != "real":
            return []
        buses = load(status["file"], status["overrides"], only=list(status["buses"])).buses
    except RigError:
        return []
    return [name for name, entry in buses.items() if entry.bus.family == family]


def _status() -> Any:
    with Client(os.environ.get(ENDPOINT_VARIABLE, DEFAULT_ENDPOINT)) as client:
        return client.ask("rig/status")


def _bus_of_rig(name: str, family: str) -> tuple[Bus[Any], Path]:
    """Return a bus of the rig at the control endpoint, and the rig's run folder.  RigError if there is none."""
    status = _status()
    if status["time"] != "real":
        raise RigError(
            f"{status['rig']} runs in virtual time, and this thread does not",
            "use `with virtual_time(rig):`, or `fieldrig exec` with the file of the rig",
        )
    if name not in status["buses"]:
        raise RigError(f"{status['rig']} has no bus {name!r}", closest(name, list(status["buses"])))
    entry = load(status["file"], status["overrides"], only=[name]).buses[name]
    if entry.bus.family != family:
        raise RigError(f"{name} is a bus of the kind {entry.kind}", f"expected a {family} bus")
    return entry.bus, Path(status["run"])
