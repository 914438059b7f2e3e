"""A serial port of this host with a thread that reads and a thread that writes.

It is any port that pyserial opens: a device, a pty, socket://HOST:PORT (or tcp://), rfc2217://HOST:PORT.  Not every one
of them can be waited for together with sockets, so threads do it.
"""

import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from queue import SimpleQueue
from typing import Any, Final, cast

from serial import serial_for_url
from serial.serialutil import SerialException

from fieldrig.errors import BusError
from fieldrig_bus.serial.port_errors import reason
from fieldrig_bus.serial.reading import read_arrived

READ_S: Final = 0.1
"""Longest wait of a read, in seconds, after which the reading thread looks whether it should end."""


class ThreadedPort:
    def __init__(self, url: str, baud: int) -> None:
        """BusError, with its remedy, if the port is not available."""
        url = url.replace("tcp://", "socket://", 1) if url.startswith("tcp://") else url
        open_port = cast(Callable[..., Any], serial_for_url)
        try:
            self._port = open_port(url, baud, timeout=READ_S)
        except (SerialException, OSError, ValueError) as cause:
            expected = "expected a device, a pty, tcp://HOST:PORT or rfc2217://HOST:PORT"
            raise BusError(f"cannot open {url}: {reason(cause)}", expected) from cause
        self._is_open = True
        self._unsent: SimpleQueue[bytes | None] = SimpleQueue()
        self._threads: list[threading.Thread] = []

    def start(self, on_data: Callable[[bytes], None], on_gone: Callable[[str], None]) -> None:
        """Call the handlers, in threads of the port."""
        for work in (partial(self._read, on_data), self._write):
            thread = threading.Thread(target=self._work, args=(work, on_gone), daemon=True)
            thread.start()
            self._threads.append(thread)

    def send(self, data: bytes) -> None:
        self._unsent.put(data)

    def close(self) -> None:
        """Send the rest, drop DTR, which makes a modem hang up, and close the port."""
        self._unsent.put(None)
        for thread in reversed(self._threads):  # the one that writes first
            thread.join(timeout=1.0)
            self._is_open = False
        with suppress(SerialException, OSError):
            self._port.dtr = False
        with suppress(SerialException, OSError):
            self._port.close()

    def _work(self, work: Callable[[], None], on_gone: Callable[[str], None]) -> None:
        try:
            work()
        except (SerialException, OSError, TypeError) as cause:  # TypeError: pyserial, if the port closes while it reads
            if self._is_open:
                on_gone(str(cause))

    def _read(self, on_data: Callable[[bytes], None]) -> None:
        while self._is_open:
            if data := read_arrived(self._port):
                on_data(data)

    def _write(self) -> None:
        while (data := self._unsent.get()) is not None:
            self._port.write(data)
