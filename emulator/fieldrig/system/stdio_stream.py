"""Standard input as a stream of bytes that can be waited for, on any system.

A thread reads, because not every system can wait for standard input together with something else.
"""

import os
import sys
import threading
from collections.abc import Iterator
from queue import Empty, Queue
from typing import Final

LARGEST: Final = 65_536


def chunks(moment_s: float) -> Iterator[bytes]:
    """Yield what arrives on standard input, and empty bytes after each `moment_s` without input, until it ends."""
    arrived: Queue[bytes] = Queue(maxsize=100)

    def read() -> None:
        while data := os.read(sys.stdin.fileno(), LARGEST):
            arrived.put(data)
        arrived.put(b"")

    threading.Thread(target=read, daemon=True).start()
    while True:
        try:
            data = arrived.get(timeout=moment_s)
        except Empty:
            yield b""
        else:
            if not data:
                return
            yield data
