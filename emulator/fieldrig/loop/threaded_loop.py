"""An event loop that shares its lock, so that other threads can call devices while it waits.

Waking a loop takes longer than many devices need for the message it is woken for.  A thread of this loop therefore
handles its messages itself, while it holds the lock.  The loop holds the lock whenever it is not waiting for events, so
a device is never called by two threads at once.  The loop is asyncio's own, as uvloop cannot be interrupted between its
work and its waiting.
"""

import asyncio
import selectors
import threading
from collections.abc import Callable
from contextvars import Context
from typing import Final, NoReturn, TypeVarTuple

Arguments = TypeVarTuple("Arguments")

PATIENCE_S: Final = 1.0
"""How long `close` waits for a thread that does not end; threads that wait for messages end when none can come."""


class ThreadedLoop(asyncio.SelectorEventLoop):
    """A loop that holds its lock except while it waits, from when it is made until it is closed."""

    def __init__(self) -> None:
        self.lock: Final = threading.Lock()
        """A thread that holds it may call devices, and everything else that belongs to the loop's own thread."""
        self.lock.acquire()
        self._home = threading.get_ident()
        self._threads: list[threading.Thread] = []
        super().__init__(_Selector(self.lock))
        self.set_debug(False)  # debug mode insists on a single thread

    def start_thread(self, name: str, work: Callable[[], None]) -> None:
        """Run `work` in a thread that takes the lock for each message.  It must end before the loop closes.

        The loop handles what `work` raises.
        """
        thread = threading.Thread(target=self._run, args=(work,), name=name, daemon=True)
        self._threads.append(thread)
        thread.start()

    def call_soon(
        self, callback: Callable[[*Arguments], object], *args: *Arguments, context: Context | None = None
    ) -> asyncio.Handle:
        if threading.get_ident() == self._home:
            return super().call_soon(callback, *args, context=context)
        return self.call_soon_threadsafe(callback, *args, context=context)

    def call_at(
        self, when: float, callback: Callable[[*Arguments], object], *args: *Arguments, context: Context | None = None
    ) -> asyncio.TimerHandle:
        """Start a timer from any thread of the loop; `call_later` uses it too."""
        timer = super().call_at(when, callback, *args, context=context)
        if threading.get_ident() != self._home:
            self.call_soon_threadsafe(_wake)  # the loop has already chosen how long to wait
        return timer

    def close(self) -> None:
        """Close the loop and wait for its threads, at most `PATIENCE_S` for each."""
        if self.is_closed():
            return
        super().close()
        self.lock.release()
        for thread in self._threads:
            thread.join(PATIENCE_S)

    def _run(self, work: Callable[[], None]) -> None:
        asyncio._set_running_loop(self)
        try:
            work()
        except BaseException as fault:  # noqa: BLE001  the loop raises it
            self.call_soon_threadsafe(_raise, fault)


class _Selector(selectors.DefaultSelector):
    """A selector that releases the loop's lock while it waits."""

    def __init__(self, lock: threading.Lock) -> None:
        super().__init__()
        self._lock = lock

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        self._lock.release()
        try:
            ready = super().select(timeout)
        finally:
            self._lock.acquire()
        # A thread may have closed a file that was ready; anything else it waits for is found by the next call.
        registered = self.get_map()
        return [(key, events) for key, events in ready if registered.get(key.fd) is key]


def _raise(fault: BaseException) -> NoReturn:
    raise fault


def _wake() -> None:
    """Do nothing; scheduling the call wakes the loop."""
