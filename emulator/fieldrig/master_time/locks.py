"""A lock that gives the baton away while its caller waits for it.

`threading` makes Condition, Event, Semaphore, Barrier, Timer and the queues of it, also those that were made before the
block, as these make a new lock for each wait.
"""

import _thread
from collections import deque
from typing import Final

from fieldrig.master_time.active import any_scheduler, waiting_scheduler
from fieldrig.master_time.member import Member, new_lock

FOREIGN_S: Final = 0.05
"""Real time for which a member waits at a time for a thread in real time to release its lock."""


class Lock:
    """`threading.Lock`; threads in real time wait for it as usual."""

    __slots__ = ("__weakref__", "_is_held_outside", "_lock", "_waiting")

    def __init__(self) -> None:
        self._lock = new_lock()
        self._waiting: deque[Member] = deque()
        self._is_held_outside = False
        """True while a thread in real time has it; nothing in the block can make that release it."""

    def acquire(self, blocking: bool = True, timeout: float = -1) -> bool:
        if not blocking or timeout != -1:
            _check(blocking, timeout)
        scheduler = waiting_scheduler()
        if self._lock.acquire(False):
            self._is_held_outside = scheduler is None
            return True
        if scheduler is None:
            is_taken = self._lock.acquire(blocking, timeout)
            self._is_held_outside = is_taken or self._is_held_outside
            return is_taken
        if not blocking:
            scheduler.count_read()
            return False
        until_ns = None if timeout < 0 else scheduler.until(timeout)
        while not self._lock.acquire(False):
            if until_ns is not None and scheduler.rig.now_ns >= until_ns:
                return False
            if self._is_held_outside:
                _wait_outside(self._lock)
            else:
                scheduler.wait(until_ns, self._waiting)
        self._is_held_outside = False
        return True

    def release(self) -> None:
        self._lock.release()
        if self._waiting and (scheduler := any_scheduler()) is not None:
            scheduler.wake_one(self._waiting)

    def locked(self) -> bool:
        return self._lock.locked()

    def _at_fork_reinit(self) -> None:
        self._lock = new_lock()
        self._waiting.clear()

    acquire_lock, release_lock, locked_lock = acquire, release, locked

    def __enter__(self) -> bool:
        return self.acquire()

    def __exit__(self, *_: object) -> None:
        self.release()


def _wait_outside(lock: "_thread.LockType") -> None:
    if lock.acquire(True, FOREIGN_S):
        lock.release()


def _check(blocking: bool, timeout: float) -> None:
    """Raise what the lock of the system raises for wrong arguments."""
    if not blocking and timeout != -1:
        raise ValueError("cannot specify a timeout for a non-blocking call")
    if timeout < 0 and timeout != -1:
        raise ValueError("timeout value must be a non-negative number")
    if timeout > _thread.TIMEOUT_MAX:
        raise OverflowError("timeout value is too large")
