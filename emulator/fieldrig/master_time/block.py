"""The block in which a master is in virtual time."""

import asyncio
import gc
import logging
import os
import queue
import socket
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib.machinery import ExtensionFileLoader
from typing import Any, Final

from fieldrig.master_time.active import activate, any_scheduler
from fieldrig.master_time.alarms import alarm_swaps
from fieldrig.master_time.clocks import clock_swaps, dates_of_subclasses, with_real_dates
from fieldrig.master_time.descriptors import descriptor_swaps, selector_methods
from fieldrig.master_time.doors import RigDoors, addresses_of
from fieldrig.master_time.errors import VirtualTimeError
from fieldrig.master_time.locks import Lock
from fieldrig.master_time.network import Network, SocketStandIns
from fieldrig.master_time.queries import query_swaps
from fieldrig.master_time.scheduler import Place, Scheduler
from fieldrig.master_time.swaps import Swaps
from fieldrig.master_time.terminals import Terminals
from fieldrig.master_time.threads import Refusal, hook_without_ends, is_alive, is_no_end, join, thread_swaps
from fieldrig.master_time.watchdog import Watchdog
from fieldrig.virtual.rig import Rig

LIMIT_S: Final = 24 * 3600.0
PATIENCE_S: Final = 60.0
ALWAYS_FROZEN: Final = 1000
"""Objects that are frozen from the start of the process, at most: Python 3.12 has 375, the others none."""
PROCESS: Final = "a process of its own runs in real time, and cannot be waited for in virtual time"
FOREIGN_LOOP: Final = "this event loop waits in C, where time is not virtual; asyncio's own loop works"
PROCESSES: Final = ("fork", "forkpty", "posix_spawn", "posix_spawnp", "system")


@contextmanager
def virtual_time(
    rig: Rig,
    *,
    jitter: float = 0.0,
    seed: int = 0,
    limit_s: float = LIMIT_S,
    patience_s: float = PATIENCE_S,
    is_main_punctual: bool = False,
) -> Iterator[Rig]:
    """Run the body, and all threads that it starts, in the virtual time of the rig.

    Waiting takes no real time, and each run gives the same bytes.  With `jitter`, wake-ups are late by up to this time,
    in seconds, by chance from `seed`, as on a busy host; with `is_main_punctual` those of the body are not.
    VirtualTimeError for what cannot be in virtual time: at once,
    after `limit_s` seconds of virtual time, or when a thread has computed for `patience_s` seconds of processor time.
    """
    if threading.current_thread() is not threading.main_thread():
        raise VirtualTimeError("virtual time begins in the main thread, because only that can be interrupted")
    if any_scheduler() is not None:
        raise VirtualTimeError("this process is in virtual time already")
    scheduler, swaps, network = Scheduler(rig, limit_s, jitter, seed), Swaps(), Network()
    scheduler.is_main_punctual = is_main_punctual
    watchdog, doors = Watchdog(scheduler, patience_s), None
    is_frozen = _freeze()
    try:
        doors = scheduler.doors = RigDoors(scheduler, network)
        scheduler.place = Place.RIG  # the watchdog has patience until the block begins
        _swap(swaps, network, doors.terminals)
        scheduler.place = Place.MEMBER
        activate(scheduler)
        network.rig_addresses = addresses_of(rig)
        scheduler.one_cpu.take(scheduler.main.native)
        doors.open()
        yield rig
    finally:
        try:
            scheduler.end()
            if doors is not None:
                doors.close()
        finally:
            watchdog.close()
            scheduler.one_cpu.close()
            activate(None)
            swaps.undo()
            if is_frozen:
                gc.unfreeze()
    if scheduler.failure is not None:  # it was swallowed
        raise scheduler.failure
    if scheduler.left:
        raise VirtualTimeError(f"these threads did not end with the block: {', '.join(scheduler.left)}")


def _freeze() -> bool:
    """Let the collector of garbage leave alone what is older than the block; return true if that has to be undone.

    What an earlier test has left behind, such as a bus that closes when it is collected, would end at some instant of
    this block.  It is faster, too: a look at all objects of a process takes 0.2 s, and a homing of a minute had two.
    """
    if gc.get_freeze_count() > ALWAYS_FROZEN:
        return False
    gc.freeze()
    return True


def _swap(swaps: Swaps, network: Network, terminals: Terminals) -> None:
    sockets = SocketStandIns(network)
    swaps.everywhere(
        [
            *clock_swaps(), *descriptor_swaps(), *thread_swaps(), *sockets.names(), *_terminal_swaps(terminals),
            *_refusals(), *alarm_swaps(), *query_swaps(), *_loop_swaps(),
            (threading.Lock, Lock), (queue.SimpleQueue, queue._PySimpleQueue),  # type: ignore[attr-defined]
        ]
    )  # fmt: skip
    swaps.attribute(threading, "_allocate_lock", Lock)
    swaps.attribute(threading, "_CRLock", None)
    # trio asserts that a lock is one in C, which a signal does not interrupt; here none comes in between either.
    swaps.attribute(threading._RLock, "__module__", "_thread")
    swaps.attribute(threading, "excepthook", hook_without_ends(threading.excepthook))
    executors = logging.getLogger("concurrent.futures")  # it calls the end of a worker critical
    executors.addFilter(is_no_end)
    swaps.later(lambda: executors.removeFilter(is_no_end))
    swaps.attribute(threading.Thread, "join", join)
    swaps.attribute(threading.Thread, "is_alive", is_alive)
    if hasattr(asyncio, "WindowsProactorEventLoopPolicy"):
        swaps.attribute(asyncio.WindowsProactorEventLoopPolicy, "_loop_factory", asyncio.SelectorEventLoop)
    for name in ("create_module", "exec_module"):
        swaps.attribute(ExtensionFileLoader, name, with_real_dates(getattr(ExtensionFileLoader, name)))
    for kind, name, method in (*selector_methods(), *dates_of_subclasses()):
        swaps.attribute(kind, name, method)
    for name, method in sockets.methods().items():
        swaps.attribute(socket.socket, name, method)


def _terminal_swaps(terminals: Terminals) -> list[tuple[Any, Any]]:
    if sys.platform != "win32":
        with suppress(ImportError):
            from fieldrig.master_time.terminal_calls import TerminalCalls

            return TerminalCalls(terminals).swaps()
    return []


def _loop_swaps() -> list[tuple[Any, Any]]:
    """Return the usual event loop of Windows, which waits in C, with the other one that asyncio has there."""
    return [(asyncio.ProactorEventLoop, asyncio.SelectorEventLoop)] if hasattr(asyncio, "ProactorEventLoop") else []


def _refusals() -> list[tuple[Any, Any]]:
    calls = [(getattr(os, name), PROCESS) for name in PROCESSES if hasattr(os, name)]
    if (processes := sys.modules.get("_posixsubprocess")) is not None:
        calls.append((processes.fork_exec, PROCESS))
    if (uvloop := sys.modules.get("uvloop")) is not None:  # None is there where an import was forbidden
        calls += [(getattr(uvloop, name), FOREIGN_LOOP) for name in ("new_event_loop", "run")]
    return [(real, Refusal(real, what).call) for real, what in calls]
