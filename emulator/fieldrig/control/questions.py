"""Questions of tools that wait for their answers, up to a number, and answered at the pace of the process.

They come from threads of Zenoh, faster than a device that keeps a cycle can answer.  What does not fit is refused by
the thread that brings it, and costs the event loop nothing.
"""

from collections import deque
from collections.abc import Callable
from typing import Final, Generic, TypeVar

from fieldrig.loop.pace import Pace
from fieldrig.outside.limits import Reached

Q = TypeVar("Q")

MOST_QUESTIONS: Final = 1_000
"""Questions that wait in one process."""
AT_ONCE: Final = 4
"""Questions that are answered before the event loop continues with others."""


class Questions(Generic[Q]):
    """Hands questions over to a loop.  `put` may be called by any thread, everything else by the loop's own."""

    def __init__(self, name: str, soon: Callable[[Callable[[], None]], None], start: Callable[[Q], None]) -> None:
        """`soon` calls an action in the loop, from any thread; `start` begins to answer a question."""
        self._soon, self._start = soon, start
        self._waiting: deque[Q] = deque()
        self._is_called = False
        self.reached = Reached(name)
        self.pace: Pace | None = None
        """The pace of the answers, or None if there is no reason to wait."""

    def put(self, question: Q) -> bool:
        """Add a question.  Return false if too many wait."""
        if len(self._waiting) >= MOST_QUESTIONS:
            self.reached.note("questions over the limit", f"{MOST_QUESTIONS} questions wait; another one is refused")
            return False
        self._waiting.append(question)
        self._call()
        return True

    def take_turn(self) -> None:
        """Answer a question, because it is the turn of questions."""
        if self._waiting:
            self._start(self._waiting.popleft())
            self._call()

    def _call(self) -> None:
        if not self._is_called:
            self._is_called = True
            self._soon(self._work)

    def _work(self) -> None:
        self._is_called = False  # before the look at what waits, so that no question of another thread is missed
        for _ in range(AT_ONCE):
            if not self._waiting or not (self.pace is None or self.pace.is_free(self)):
                return
            self._start(self._waiting.popleft())
        if self._waiting:
            self._call()
