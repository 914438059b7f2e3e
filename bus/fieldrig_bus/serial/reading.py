"""Reading from a port of pyserial, whatever it is: a device, a pty, socket:// or rfc2217://."""

from contextlib import suppress
from typing import Any, Final

from serial.serialutil import SerialException
from serial.urlhandler.protocol_socket import Serial as SocketSerial

MOST_AT_ONCE: Final = 64 * 1024
"""Bytes that are read at once."""


def read_arrived(port: Any) -> bytes:
    """Return everything that has arrived, up to `MOST_AT_ONCE` bytes; wait for it as long as the port's time-out says.

    Return no bytes after the time-out.  SerialException or OSError for a port that is gone.
    """
    data: bytes = port.read(1)
    if data:
        with suppress(SerialException):  # the next call raises it, and this one has data to return
            data += _rest(port)
    return data


def _rest(port: Any) -> bytes:
    """Return what has arrived, without waiting.

    `in_waiting` of `socket://` says 1 for any number of bytes.  A thread that reads a byte per call waits each time for
    the interpreter, so that 38400 bit/s were too much for it beside 40 busy connections.  A read without a time-out
    takes what a socket has; to other ports the new time-out would cost a conversation (RFC 2217).
    """
    is_socket = isinstance(port, SocketSerial)
    if not is_socket:
        return bytes(port.read(min(port.in_waiting, MOST_AT_ONCE)))
    timeout_s, port.timeout = port.timeout, 0
    try:
        return bytes(port.read(MOST_AT_ONCE))
    finally:
        port.timeout = timeout_s
