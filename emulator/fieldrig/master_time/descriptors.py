"""Waits for file descriptors: `select` in all its forms, and blocking calls of a socket.

The descriptors are real, so that nothing else has to know about them; only the wait is virtual.  Before time passes,
the scheduler asks whether one is ready.
"""

import select
import selectors
import sys
from collections.abc import Callable
from typing import Any, Final

from fieldrig.master_time.active import waiting_scheduler
from fieldrig.master_time.scheduler import Scheduler

_real_select = select.select
_real_poll: Final[Any] = getattr(select, "poll", None)
_real_epoll: Final[Any] = getattr(select, "epoll", None)


def wait_for(scheduler: Scheduler, timeout_s: float | None, ask: Callable[[], Any]) -> Any:
    """Return what `ask()` finds without waiting, at the latest after the time-out."""
    found = ask()
    if found:
        return found
    if timeout_s is not None and timeout_s <= 0:
        scheduler.poll()
        return ask()
    scheduler.wait(scheduler.until(timeout_s), ready=lambda: bool(ask()))
    return ask()


class SelectStandIn:
    """`select.select`."""

    def select(self, reads: Any, writes: Any, errors: Any, timeout: float | None = None) -> Any:
        scheduler = waiting_scheduler()
        if scheduler is None:
            return _real_select(reads, writes, errors, timeout)
        lists = list(reads), list(writes), list(errors)

        def ask() -> Any:
            found = _real_select(*lists, 0)
            return found if any(found) else None

        return wait_for(scheduler, timeout, ask) or ([], [], [])


class _Poller:
    """An object of `select.poll` or `select.epoll`, with a wait that is virtual for a member."""

    PER_SECOND = 1.0

    def __init__(self, real: Any) -> None:
        self._real = real

    def poll(self, timeout: float | None = None, *most: int) -> Any:
        scheduler = waiting_scheduler()
        if scheduler is None:
            return self._real.poll(timeout, *most)
        timeout_s = None if timeout is None or timeout < 0 else timeout / self.PER_SECOND
        return wait_for(scheduler, timeout_s, self._asking(most))

    def _asking(self, most: tuple[int, ...]) -> Callable[[], Any]:
        """Return the call that asks which descriptors are ready, without waiting."""
        return lambda: self._real.poll(0, *most)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._real, name)


class _MillisecondPoller(_Poller):
    PER_SECOND = 1000.0


class _EpollPoller(_Poller):
    def _asking(self, most: tuple[int, ...]) -> Callable[[], Any]:
        """Return the same, which keeps what it finds: epoll says an edge (ET) or a single event (ONESHOT) only once."""
        found: list[Any] = []

        def ask() -> list[Any]:
            if not found:
                found.extend(self._real.poll(0, *most))
            return found

        return ask

    def __enter__(self) -> "_EpollPoller":
        return self

    def __exit__(self, *_: object) -> None:
        self._real.close()


class PollerStandIns:
    """`select.poll` and `select.epoll`."""

    def poll(self) -> _Poller:
        return _MillisecondPoller(_real_poll())

    def epoll(self, *arguments: Any, **options: Any) -> _Poller:
        return _EpollPoller(_real_epoll(*arguments, **options))


def selector_method(real: Callable[..., Any]) -> Callable[..., Any]:
    """Return the method `select` of a class of `selectors`, which event loops wait in."""

    def select(self: Any, timeout: float | None = None) -> Any:
        scheduler = waiting_scheduler()
        if scheduler is None:
            return real(self, timeout)
        return wait_for(scheduler, timeout, lambda: real(self, 0))

    return select


def descriptor_swaps() -> list[tuple[Any, Any]]:
    stand_ins = PollerStandIns()
    swaps: list[tuple[Any, Any]] = [(_real_select, SelectStandIn().select)]
    swaps += [(_real_poll, stand_ins.poll)] if _real_poll is not None else []
    return swaps + ([(_real_epoll, stand_ins.epoll)] if _real_epoll is not None else [])


def selector_methods() -> list[tuple[type, str, Callable[..., Any]]]:
    """Return the classes of `selectors` with their method that waits, and its stand-in."""
    names = ("SelectSelector", "PollSelector", "EpollSelector", "DevpollSelector", "KqueueSelector")
    kinds = [getattr(selectors, name) for name in names if hasattr(selectors, name)]
    return [(kind, "select", selector_method(kind.select)) for kind in kinds]


def is_ready(descriptor: int, is_write: bool) -> bool:
    """Return whether a descriptor can be read, or written, without waiting."""
    if sys.platform != "win32" and _real_poll is not None:
        poller = _real_poll()
        poller.register(descriptor, select.POLLOUT if is_write else select.POLLIN)
        return bool(poller.poll(0))
    sets = ([], [descriptor]) if is_write else ([descriptor], [])
    return any(_real_select(*sets, [], 0))
