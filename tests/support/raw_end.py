"""One end of a connection or a line, for tests that write and read raw bytes."""

import os
from collections.abc import Callable

from hub_bench import LoopBench


class RawEnd:
    """Raw bytes to and from a descriptor, while the loop of its bench runs; `close` closes the descriptor."""

    def __init__(self, bench: LoopBench, fd: int, close: Callable[[], None]) -> None:
        self._loop_bench, self.fd, self._close = bench, fd, close
        self.received = bytearray()
        self.is_open = True
        """False once the other side has ended the connection."""
        self._is_closed = False
        os.set_blocking(fd, False)
        bench.loop.add_reader(fd, self._on_readable)

    def write(self, data: bytes) -> None:
        assert os.write(self.fd, data) == len(data)

    def read(self, size: int) -> bytes:
        """Wait for `size` bytes and return them; fewer if the connection ends before."""
        self._loop_bench.pump(lambda: len(self.received) >= size or not self.is_open)
        data = bytes(self.received[:size])
        del self.received[:size]
        return data

    def until_closed(self) -> None:
        """Wait until the other side has ended the connection."""
        self._loop_bench.pump(lambda: not self.is_open)

    def close(self) -> None:
        if not self._is_closed:
            self._is_closed = True
            self._loop_bench.loop.remove_reader(self.fd)
            self._close()

    def _on_readable(self) -> None:
        try:
            data = os.read(self.fd, 4096)
        except BlockingIOError:
            return
        except OSError:  # reset by the other side, or EIO of a pty
            data = b""
        self.received += data
        if not data:
            self.is_open = False
            self._loop_bench.loop.remove_reader(self.fd)
