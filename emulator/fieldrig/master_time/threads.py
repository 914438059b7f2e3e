"""Threads that a member starts are members as well; and what would leave the process is refused."""

import _thread
import logging
import sys
import threading
from collections.abc import Callable
from typing import Any
from weakref import WeakKeyDictionary

from fieldrig.master_time.active import seeing_scheduler, waiting_scheduler
from fieldrig.master_time.errors import EndedError, VirtualTimeError
from fieldrig.master_time.member import Member
from fieldrig.master_time.places import where
from fieldrig.master_time.scheduler import Place, Scheduler

_members: WeakKeyDictionary[threading.Thread, tuple[Scheduler, Member]] = WeakKeyDictionary()
"""The members that threads are."""
_real_start = _thread.start_new_thread
_real_start_joinable: Any = getattr(_thread, "start_joinable_thread", None)
_real_join, _real_is_alive = threading.Thread.join, threading.Thread.is_alive


class ThreadStandIns:
    """`_thread.start_new_thread`, and `start_joinable_thread` of Python 3.13."""

    def __init__(self) -> None:
        self._count = 0

    def start(self, function: Callable[..., Any], args: tuple[Any, ...] = (), kwargs: Any = None) -> int:
        scheduler = seeing_scheduler()
        if scheduler is None:
            return _real_start(function, args, kwargs or {})
        member = self._member(scheduler, function)
        job: list[Any] = [(function, args, kwargs or {})]
        del function, args, kwargs  # the thread lets go of them at its end
        ident = _real_start(_run, (scheduler, member, job))
        scheduler.add(member)
        return ident

    def start_joinable(self, function: Callable[[], Any], handle: Any = None, daemon: bool = True) -> Any:
        scheduler = seeing_scheduler()
        if scheduler is None:
            return _real_start_joinable(function, handle=handle, daemon=daemon)
        member = self._member(scheduler, function)
        job: list[Any] = [(function, (), {})]
        del function
        made = _real_start_joinable(lambda: _run(scheduler, member, job), handle=handle, daemon=daemon)
        scheduler.add(member)
        return made

    def _member(self, scheduler: Scheduler, function: Callable[..., Any]) -> Member:
        if scheduler.place is Place.DOORS:
            raise refused(scheduler, "this port of the rig needs a thread of real time")
        self._count += 1
        owner = getattr(function, "__self__", None)
        if not isinstance(owner, threading.Thread):
            return Member(f"thread {self._count}")
        member = Member(owner.name)
        _members[owner] = scheduler, member
        return member


def _run(scheduler: Scheduler, member: Member, job: list[Any]) -> None:
    """Run a thread from its first turn to its end."""
    scheduler.started(member)
    try:
        function, args, kwargs = job.pop()
        if not scheduler.is_over:
            function(*args, **kwargs)
        else:
            _forget_unstarted(function)
    except EndedError:
        pass
    finally:
        # What the thread held goes while it has the baton, because finalizers may wake others.
        job.clear()
        function = args = kwargs = None
        scheduler.finished(member)


def _forget_unstarted(function: Callable[..., Any]) -> None:
    """Remove a thread that had no turn before the end from `threading.enumerate`, which lists it while it starts."""
    starting: dict[Any, Any] = getattr(threading, "_limbo", {})
    starting.pop(getattr(function, "__self__", None), None)


def join(self: threading.Thread, timeout: float | None = None) -> None:
    """`Thread.join`."""
    caller, (scheduler, member) = waiting_scheduler(), _members.get(self, (None, None))
    if caller is None or member is None or scheduler is not caller:
        _real_join(self, timeout)
        return
    if member is caller.running:
        raise RuntimeError("cannot join current thread")
    until_ns = caller.until(timeout)
    while not member.is_done:
        if until_ns is not None and caller.rig.now_ns >= until_ns:
            return
        caller.wait(until_ns, member.joiners)
    if not member.is_lost:
        _real_join(self)  # a moment of real time, until the thread of the system has ended


def is_alive(self: threading.Thread) -> bool:
    """`Thread.is_alive`."""
    caller, (_, member) = waiting_scheduler(), _members.get(self, (None, None))
    if member is None:
        return _real_is_alive(self)
    if member.is_done and not member.is_lost:
        _real_join(self)
        return False
    if caller is not None:
        caller.count_read()
    return _real_is_alive(self)


def hook_without_ends(real: Callable[[Any], Any]) -> Callable[[Any], Any]:
    """Return `threading.excepthook`, which keeps quiet about threads that the block ends, and about its own errors.

    The main thread gets those errors.
    """

    def hook(arguments: Any) -> Any:
        return None if issubclass(arguments.exc_type, (EndedError, VirtualTimeError)) else real(arguments)

    return hook


def is_no_end(record: logging.LogRecord) -> bool:
    """Return whether a line of the log is about anything but a thread that the end of the block has ended."""
    return not (record.exc_info and isinstance(record.exc_info[1], EndedError | VirtualTimeError))


def thread_swaps() -> list[tuple[Any, Any]]:
    stand_ins = ThreadStandIns()
    swaps: list[tuple[Any, Any]] = [(_real_start, stand_ins.start)]
    if _real_start_joinable is not None:
        swaps.append((_real_start_joinable, stand_ins.start_joinable))
    return swaps


class Refusal:
    """A call that a member cannot make, as what it does goes on in real time."""

    def __init__(self, real: Callable[..., Any], what: str) -> None:
        self._real, self._what = real, what

    def call(self, *arguments: Any, **options: Any) -> Any:
        self.check()
        return self._real(*arguments, **options)

    def check(self) -> None:
        scheduler = seeing_scheduler()
        if scheduler is not None:
            raise refused(scheduler, self._what)


def refused(scheduler: Scheduler, what: str) -> VirtualTimeError:
    """Return the error of a call that leaves virtual time, with the thread and the line that made it."""
    name = threading.current_thread().name
    error = VirtualTimeError(f"{what}\n  thread {name} at {where(sys._getframe(1))}")
    if scheduler.failure is None:
        scheduler.failure = error
    return error
