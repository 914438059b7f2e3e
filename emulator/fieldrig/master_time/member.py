"""One thread of a master, as the scheduler sees it."""

import _thread
from collections import deque
from collections.abc import Callable

new_lock = _thread.allocate_lock
"""The lock of the system, also while the names of the standard library lead to ours."""
this_thread = _thread.get_ident


class Member:
    """A thread that runs only while it has the baton."""

    __slots__ = (
        "baton", "error", "hears_rig", "ident", "is_delayed", "is_done", "is_lost", "is_notified", "is_waiting",
        "joiners", "name", "native", "reads", "ready", "refused", "turn",
    )  # fmt: skip

    def __init__(self, name: str) -> None:
        self.name = name
        self.ident = self.native = 0
        """Its numbers in Python and in the system, once it runs."""
        self.baton = new_lock()
        self.baton.acquire()
        self.is_done = False
        self.is_lost = False
        """True if it was given up, because it would not hand on the baton; it has no turn any more."""
        self.is_waiting = self.is_notified = False
        self.is_delayed = False
        """True from when it was woken until it wakes up late, by jitter."""
        self.hears_rig = False
        """True while it waits for what the rig does, at an end of a bus of its own."""
        self.turn = 0
        """Counts its waits, so that an old timer does not end a new wait."""
        self.ready: Callable[[], bool] | None = None
        """Tells whether a descriptor that it waits for is ready."""
        self.joiners: deque[Member] = deque()
        """The members that wait for its end."""
        self.reads = 0
        """Looks at the clock since it last waited."""
        self.refused = 0
        """The number of waits that the end of the block has refused."""
        self.error: BaseException | None = None
        """The error that it has to raise when it has the baton again."""
