"""The order of requests to a unit, when clients ask faster than it answers.

A unit has at most `MOST_AT_A_UNIT` requests at a time, and the clients with more for it take turns, a request each.  So
a client that pipelines does not delay another one by more than a request of its own.
"""

from collections import Counter, deque
from typing import Final, Protocol

MOST_AT_A_UNIT: Final = 8
"""Requests of all clients that a unit has at a time."""


class Client(Protocol):
    def go_on(self) -> None:
        """Send the next request, if `Turns.begin` allows it."""


class Turns:
    def __init__(self, most: int = MOST_AT_A_UNIT) -> None:
        self._most = most
        self._asked: Counter[int] = Counter()
        self._waiting: dict[int, deque[Client]] = {}
        self._free: deque[int] = deque()
        self._is_giving = False

    def begin(self, unit: int, client: Client) -> bool:
        """Return whether a request to this unit may go now; if not, `client.go_on` is called when it may."""
        if self._asked[unit] < self._most:
            self._asked[unit] += 1
            return True
        waiting = self._waiting.setdefault(unit, deque())
        if client not in waiting:
            waiting.append(client)
        return False

    def end(self, unit: int) -> None:
        """Note that a request was answered, or is given up."""
        self._asked[unit] -= 1
        if unit in self._waiting:
            self._free.append(unit)
            self._give()

    def leave(self, client: Client) -> None:
        for unit, waiting in list(self._waiting.items()):
            if client in waiting:
                waiting.remove(client)
            if not waiting:
                del self._waiting[unit]

    def _give(self) -> None:
        """Give the free places to those whose turn it is; an answer may come while a request is being sent."""
        if self._is_giving:
            return
        self._is_giving = True
        try:
            while self._free:
                self._give_one(self._free.popleft())
        finally:
            self._is_giving = False

    def _give_one(self, unit: int) -> None:
        waiting = self._waiting.get(unit)
        if waiting is None:
            return
        while waiting and self._asked[unit] < self._most:
            waiting.popleft().go_on()
        if not waiting:
            self._waiting.pop(unit, None)
