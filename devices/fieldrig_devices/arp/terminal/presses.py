"""Key presses: which keys are down, and presses that are still waiting, one after the other."""

from collections import deque
from collections.abc import Callable
from typing import Final

from fieldrig.clock import MS, Clock

DOWN_NS: Final = 100 * MS
UP_NS: Final = 50 * MS
_MOST_WAITING: Final = 256


class Presses:
    def __init__(self, clock: Clock, names: frozenset[str], on_change: Callable[[str, bool], None]) -> None:
        """`on_change` is called with the name of the key, and whether it went down."""
        self._clock, self._names, self._on_change = clock, names, on_change
        self.down: set[str] = set()
        self._waiting: deque[str] = deque()
        self._is_pressing = False
        self.last = ""

    def set(self, name: str, is_down: bool) -> None:
        if is_down == (name in self.down):
            return
        if is_down:
            self.down.add(name)
        else:
            self.down.discard(name)
        self._on_change(name, is_down)

    def press(self, names: str) -> None:
        """Press keys, which are separated by blanks, for `DOWN_NS` each.  Raises ValueError for an unknown key."""
        keys = names.upper().split()
        for key in keys:
            if key not in self._names:
                raise ValueError(
                    f"{key!r} is not a key of this terminal; expected one of {', '.join(sorted(self._names))}"
                )
        if len(self._waiting) + len(keys) > _MOST_WAITING:
            raise ValueError(f"{len(self._waiting)} keys are still waiting; expected at most {_MOST_WAITING} in total")
        self._waiting.extend(keys)
        if not self._is_pressing:
            self._next()

    def _next(self) -> None:
        self._is_pressing = bool(self._waiting)
        if self._is_pressing:
            self.last = self._waiting.popleft()
            self.set(self.last, True)
            self._clock.call_at(self._clock.now_ns() + DOWN_NS, self._release)

    def _release(self) -> None:
        self.set(self.last, False)
        self._clock.call_at(self._clock.now_ns() + UP_NS, self._next)
