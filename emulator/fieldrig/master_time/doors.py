"""The ports of a rig, served in virtual time to the members of a block.

A port is the same code as in real time.  It runs in an event loop of asyncio that never waits: the thread that lets
time pass runs it until it has nothing left to do at this instant.  Messages from the bus are handled there as well, and
not while the rig runs, because a port may use its loop.  What a port gives to other threads is done at once instead.
"""

import asyncio
import selectors
from collections import deque
from collections.abc import Callable, Coroutine, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path
from typing import Any, Final

from fieldrig.bus import Doors, ModelBus, Port, ProgramBus
from fieldrig.clock import S, Timer, VirtualClock, Watchdog
from fieldrig.device import WayIn
from fieldrig.link import Link
from fieldrig.loop.pace import Pace
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.network import Network
from fieldrig.master_time.scheduler import Scheduler
from fieldrig.master_time.terminals import Terminal, Terminals
from fieldrig.system.own_files import part_of
from fieldrig.virtual.node import NodeLink
from fieldrig.virtual.rig import Rig

LINE: Final = "fieldrig://"
"""Begins the URL of a line of the rig."""
MOST_LOOKS: Final = 10_000
"""Rounds at one instant after which ports and clients are taken for an endless exchange."""
_select = selectors.DefaultSelector.select
_get_running_loop, _set_running_loop = asyncio._get_running_loop, asyncio._set_running_loop


class _IdleSelector(selectors.DefaultSelector):
    """Never waits, and notes how long the loop would have waited."""

    def __init__(self) -> None:
        super().__init__()
        self.on_idle: Callable[[float | None], None] = lambda _: None

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        found = _select(self, 0)
        if not found and timeout != 0:
            self.on_idle(timeout)
        return found

    def has_events(self) -> bool:
        return bool(_select(self, 0))


class _AtOnce(ThreadPoolExecutor):
    """Does its jobs in the thread that submits them."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> "Future[Any]":
        done: Future[Any] = Future()
        try:
            done.set_result(fn(*args, **kwargs))
        except Exception as fault:  # noqa: BLE001  the caller gets it
            done.set_exception(fault)
        return done


class DoorHub:
    """One bus, as its ports see it."""

    def __init__(self, doors: "RigDoors", bus: str) -> None:
        self._doors, self._bus = doors, bus
        self.clock = doors.clock
        self.pace: Pace | None = None

    def join(self, member: str) -> Link[Any]:
        """ValueError if the bus has a member of this name."""
        rig = self._doors.rig
        if rig.clients.has(member, self._bus):
            raise ValueError(f"{self._bus} already has a member {member!r}")
        return _DoorLink(self._doors, rig.clients.join(member, self._bus).link(self._bus))

    def leave(self, member: str) -> None:
        self._doors.rig.clients.leave(member, self._bus)

    def waiting(self, member: str) -> int:
        return self._doors.rig.clients.waiting(member, self._bus)

    def on_doors(self, call: Callable[[Doors], None]) -> None:
        arrived = self._doors.arrived.append
        self._doors.rig.clients.on_doors(self._bus, lambda doors: arrived((call, doors)))

    def terminal(self, name: str) -> Terminal:
        """Return a serial port that programs open by this path, instead of a pty."""
        place = name if "://" in name else self._doors.rig.config.run / name
        return Terminal(self._doors.terminals, place)

    def path(self, name: str) -> Path:
        return part_of(self._doors.rig.config.run, name)


class _DoorLink:
    def __init__(self, doors: "RigDoors", link: NodeLink) -> None:
        self._doors, self._link = doors, link

    def send(self, message: Any) -> None:
        self._link.send(message)

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        arrived = self._doors.arrived.append
        self._link.on_receive(lambda message: arrived((handler, message)), interest)


class DoorClock:
    """The clock of the ports: a virtual one that moves with the rig."""

    def __init__(self, rig: Rig) -> None:
        self._rig, self.timers = rig, VirtualClock(rig.now_ns)

    def now_ns(self) -> int:
        return self._rig.now_ns

    def call_at(self, when_ns: int, action: Callable[[], None]) -> Timer:
        return self.timers.call_at(when_ns, action)

    def watch(self, action: Callable[[], None]) -> Watchdog:
        return self.timers.watch(action)

    def late_ns(self) -> int:
        return 0


class RigDoors:
    """All ports of a rig."""

    def __init__(self, scheduler: Scheduler, network: Network) -> None:
        self.rig, self._scheduler, self._network = scheduler.rig, scheduler, network
        self.clock = DoorClock(self.rig)
        self.arrived: deque[tuple[Callable[[Any], None], Any]] = deque()
        """The messages that have arrived at ports, with their handlers."""
        self._selector = _IdleSelector()
        self._selector.on_idle = self._on_idle
        self._loop = asyncio.SelectorEventLoop(self._selector)
        self._loop.set_default_executor(_AtOnce(1))
        self._wake_ns: int | None = None
        self._has_work = True
        self._is_terminal_used = False
        """True once a program has opened a serial port."""
        self.terminals = Terminals(self._call, self._line)
        self._ports: list[Port] = []
        self._fault: BaseException | None = None

    @property
    def have_written(self) -> bool:
        return bool(self.arrived)

    @property
    def have_clients(self) -> bool:
        return self._network.has_connections() or self.terminals.are_open

    def next_ns(self) -> int | None:
        timer_ns, wake_ns = self.clock.timers.next_ns(), self._wake_ns
        if timer_ns is None or wake_ns is None:
            return wake_ns if timer_ns is None else timer_ns
        return min(timer_ns, wake_ns)

    def open(self) -> None:
        """Open the ports of all buses.  BusError if one is not available."""
        for bus in self.rig.buses.values():
            for port in bus.ports():
                self._ports.append(port)
                self._do(port.open(DoorHub(self, bus.name)))

    def close(self) -> None:
        """Close them, and the loop.

        This takes no virtual time, so that the rig ends at the instant at which the master has ended.  A port that
        would take some, for example for a client that is gone, is cut short.
        """
        try:
            while self._ports:
                task = self._begin(self._ports.pop().close())
                self._scheduler.serve()
                if not task.done():
                    task.cancel()
                    self._has_work = True
                    self._scheduler.serve()
                elif not task.cancelled():
                    task.result()
        finally:
            self._loop.close()

    def look(self) -> None:
        for _ in range(MOST_LOOKS):
            if not self._is_due():
                return
            self._run()
            if self._fault is not None:
                fault, self._fault = self._fault, None
                raise fault
        raise VirtualTimeError("the ports of the rig and their clients answer each other without time passing")

    def _call(self, function: Callable[[Any], None], argument: Any) -> None:
        self._is_terminal_used = True
        self.arrived.append((function, argument))

    def _line(self, url: str) -> Terminal | None:
        """Return the port of a line of the rig that a program opens by its name, `fieldrig://NAME`."""
        bus = self.rig.buses.get(url.removeprefix(LINE)) if url.startswith(LINE) else None
        if bus is None:
            return None
        by_path = self.terminals.by_path
        here = [by_path[way.address] for way in self._ways(bus) if way.address in by_path]
        if not here and isinstance(bus, ProgramBus):
            port = bus.program_port(url)
            self._ports.append(port)
            self._do(port.open(DoorHub(self, bus.name)))
            return by_path[url]
        return here[0] if here else None

    def _ways(self, bus: ModelBus[Any]) -> list[WayIn]:
        return bus.ways_in(self.rig.config.run.absolute())

    def _is_due(self) -> bool:
        if self._has_work or self.arrived:
            return True
        next_ns = self.next_ns()
        if next_ns is not None and next_ns <= self.rig.now_ns:
            return True
        # Without a client, which is the usual case for a bus of python-can in this process, the system is not asked.
        return (self._network.is_used or self._is_terminal_used) and self._selector.has_events()

    def _run(self) -> None:
        """Run the loop until it would wait."""
        loop, self._has_work = self._loop, False
        while self.arrived:
            handler, message = self.arrived.popleft()
            loop.call_soon(handler, message)
        loop.call_soon(self.clock.timers.advance_to, self.rig.now_ns)
        outer = _get_running_loop()  # that of the member which lets time pass
        _set_running_loop(None)
        try:
            loop.run_forever()
        finally:
            _set_running_loop(outer)

    def _on_idle(self, timeout_s: float | None) -> None:
        self._wake_ns = None if timeout_s is None else self.rig.now_ns + max(1, round(timeout_s * S))
        self._loop.stop()

    def _do(self, work: Coroutine[Any, Any, None]) -> None:
        """Do this, while the rig and the members go on if it takes time."""
        task = self._begin(work)
        self._scheduler.wait(ready=task.done, hears_rig=True)
        task.result()

    def _begin(self, work: Coroutine[Any, Any, None]) -> "asyncio.Task[None]":
        task = self._loop.create_task(work)
        self._has_work = True
        return task


def addresses_of(rig: Rig) -> list[str]:
    """Return the addresses of the rig file, each with its protocol, for a message."""
    run = rig.config.run
    return [f"{way.protocol} at {way.address}" for bus in rig.buses.values() for way in bus.ways_in(run)]
