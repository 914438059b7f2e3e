"""The send queue of the RS422 port: no more than the line carries is handed to it."""

from collections import deque
from collections.abc import Callable
from typing import Final

BITS_PER_CHARACTER: Final = 10
QUEUE_SIZE: Final = 2048
"""Bytes that wait for the line."""
S: Final = 1_000_000_000


class SendQueue:
    def __init__(self, send: Callable[[bytes], None], baud: int) -> None:
        self._send, self._baud = send, baud
        self._frames: deque[bytes] = deque()
        self._size = 0
        self._free_ns = 0
        """When the line has sent everything that was handed to it."""

    def clear(self) -> None:
        self._frames.clear()
        self._size = 0

    def put(self, frame: bytes) -> bool:
        """Add a frame.  Return False if there is no room for it."""
        if self._size + len(frame) > QUEUE_SIZE:
            return False
        self._frames.append(frame)
        self._size += len(frame)
        return True

    def pump(self, now_ns: int) -> None:
        """Hand frames to the line as long as it is free."""
        while self._frames and self._free_ns <= now_ns:
            frame = self._frames.popleft()
            self._size -= len(frame)
            self._free_ns = max(self._free_ns, now_ns) + len(frame) * BITS_PER_CHARACTER * S // self._baud
            self._send(frame)
