"""An event loop whose turn other threads take: what a thread has found is handled there and then, as part of the loop.

To wake a loop takes longer than many a device needs for the message that it is woken for.  So a thread that waits for
messages is a guest of the loop: it handles them itself, and hands nothing over.  Devices have the world to themselves
all the same, for there is one turn.  The loop has it whenever it isn't waiting for something to happen; a guest takes
it for one message.
A loop of asyncio's own, as one can't come between uvloop and its waiting.
"""

import asyncio
import selectors
import threading
from collections.abc import Callable
from contextvars import Context
from typing import Final, NoReturn, TypeVarTuple

Arguments = TypeVarTuple("Arguments")

PATIENCE_S: Final = 1.0
"""With a guest who doesn't go; those who wait for messages go when there can't be any more."""


class SharedLoop(asyncio.SelectorEventLoop):
    """It belongs to the thread that makes it, which has the turn until it waits in the running loop, or closes it."""

    def __init__(self) -> None:
        self.turn: Final = threading.Lock()
        """Whoever has it does as the loop would: calls devices, and everything that belongs to the loop's thread."""
        self.turn.acquire()
        self._home = threading.get_ident()
        self._guests: list[threading.Thread] = []
        super().__init__(_Waiting(self.turn))
        self.set_debug(False)  # it would insist on a single thread

    def invite(self, name: str, life: Callable[[], None]) -> None:
        """Begin a thread that takes turns.  What it raises the loop deals with.  It must end before the loop closes."""
        guest = threading.Thread(target=self._live, args=(life,), name=name, daemon=True)
        self._guests.append(guest)
        guest.start()

    def call_soon(
        self, callback: Callable[[*Arguments], object], *args: *Arguments, context: Context | None = None
    ) -> asyncio.Handle:
        if threading.get_ident() == self._home:
            return super().call_soon(callback, *args, context=context)
        return self.call_soon_threadsafe(callback, *args, context=context)

    def call_at(
        self, when: float, callback: Callable[[*Arguments], object], *args: *Arguments, context: Context | None = None
    ) -> asyncio.TimerHandle:
        """Also what is behind `call_later`."""
        timer = super().call_at(when, callback, *args, context=context)
        if threading.get_ident() != self._home:
            self.call_soon_threadsafe(_look_again)  # for how long the loop waits was settled before
        return timer

    def close(self) -> None:
        if self.is_closed():
            return
        super().close()
        self.turn.release()
        for guest in self._guests:
            guest.join(PATIENCE_S)

    def _live(self, life: Callable[[], None]) -> None:
        asyncio._set_running_loop(self)
        try:
            life()
        except BaseException as fault:  # noqa: BLE001  the loop raises it
            self.call_soon_threadsafe(_raise, fault)


class _Waiting(selectors.DefaultSelector):
    """Lets go of the turn while it waits."""

    def __init__(self, turn: threading.Lock) -> None:
        super().__init__()
        self._turn = turn

    def select(self, timeout: float | None = None) -> list[tuple[selectors.SelectorKey, int]]:
        self._turn.release()
        try:
            ready = super().select(timeout)
        finally:
            self._turn.acquire()
        # A guest may have closed what was ready; what it waits for in another way will be found again.
        registered = self.get_map()
        return [(key, events) for key, events in ready if registered.get(key.fd) is key]


def _raise(fault: BaseException) -> NoReturn:
    raise fault


def _look_again() -> None:
    """Nothing, for which the loop wakes all the same."""
