"""ISO transport on TCP, as far as an S7 client needs it (RFC 1006; ISO 8073, class 0).

A client connects with any TSAP.  Left out: expedited data, flow control, and the classes above 0.
"""

import struct
from collections.abc import Callable
from typing import Final

from fieldrig_devices.connections.connection import UNREAD, Connection

VERSION: Final = 3
_TPKT: Final = struct.Struct(">BBH")
_CONNECT: Final = struct.Struct(">BBHHB")
CONNECT_REQUEST, CONNECT_CONFIRM, DATA = 0xE0, 0xD0, 0xF0
LAST: Final = 0x80
TPDU_SIZE: Final = 0xC0
TSAPS: Final = (0xC1, 0xC2)
SIZES: Final = range(7, 14)
"""Exponents of the sizes of TPDUs."""
DEFAULT_SIZE: Final = 10
OWN_REFERENCE: Final = 1
LONGEST: Final = 8192
"""Longest packet, and longest message in several packets, in bytes."""
MOST_UNSENT: Final = 1 << 16
"""Bytes of answers that a client may leave untaken."""


class IsoSession:
    """One connection; `answer` gets each message and returns the answer, or None for silence."""

    def __init__(self, connection: Connection, answer: Callable[[bytes], bytes | None]) -> None:
        self._connection, self._answer = connection, answer
        self._received, self._message = bytearray(), bytearray()
        self._is_connected = False
        self._size = 1 << DEFAULT_SIZE
        """Largest TPDU of the client, in bytes."""

    def received(self, data: bytes) -> None:
        self._received += data
        while len(self._received) >= _TPKT.size:
            version, _, length = _TPKT.unpack_from(self._received)
            if version != VERSION or not _TPKT.size + 2 <= length <= LONGEST:
                self._connection.close()
                return
            if len(self._received) < length:
                return
            packet = bytes(self._received[_TPKT.size : length])
            del self._received[:length]
            if not self._take(packet):
                self._connection.close()
                return
            if self._connection.unsent > MOST_UNSENT:
                self._connection.cut(UNREAD)
                return

    def drained(self) -> None:
        """Do nothing: answers are written at once."""

    def ended(self) -> None:
        self._connection.close()

    def lost(self) -> None:
        self._received.clear()

    def _take(self, packet: bytes) -> bool:
        """Take a TPDU; return False if it ends the connection."""
        size, pdu_type = packet[0] + 1, packet[1] & 0xF0
        if size > len(packet):
            return False
        if pdu_type == CONNECT_REQUEST and not self._is_connected:
            return self._connect(packet[:size])
        if pdu_type == DATA and self._is_connected and size == 3:
            return self._data(packet[2] & LAST != 0, packet[size:])
        return False

    def _connect(self, header: bytes) -> bool:
        if len(header) < _CONNECT.size:
            return False
        _, _, _, reference, options = _CONNECT.unpack_from(header)
        parameters = _parameters(header[_CONNECT.size :])
        if parameters is None or options & 0xF0:
            return False
        self._is_connected = True
        size = parameters.get(TPDU_SIZE, b"")
        exponent = size[0] if len(size) == 1 and size[0] in SIZES else DEFAULT_SIZE
        self._size = 1 << exponent
        body = bytes((TPDU_SIZE, 1, exponent))
        for code in TSAPS:
            if code in parameters:
                body += bytes((code, len(parameters[code]))) + parameters[code]
        head = _CONNECT.pack(_CONNECT.size - 1 + len(body), CONNECT_CONFIRM, reference, OWN_REFERENCE, 0)
        self._write(head + body)
        return True

    def _data(self, is_last: bool, data: bytes) -> bool:
        self._message += data
        if len(self._message) > LONGEST:
            return False
        if is_last:
            answer = self._answer(bytes(self._message))
            self._message.clear()
            if answer is not None:
                self._send(answer)
        return True

    def _send(self, answer: bytes) -> None:
        """Send a message in TPDUs that the client takes."""
        room = self._size - 3
        for at in range(0, len(answer), room):
            is_last = at + room >= len(answer)
            self._write(bytes((2, DATA, LAST if is_last else 0)) + answer[at : at + room])

    def _write(self, packet: bytes) -> None:
        self._connection.write(_TPKT.pack(VERSION, 0, _TPKT.size + len(packet)) + packet)


def _parameters(data: bytes) -> dict[int, bytes] | None:
    """Return the variable part of a header by the codes of its parameters; None if it is cut."""
    by_code: dict[int, bytes] = {}
    at = 0
    while at < len(data):
        if at + 2 > len(data) or at + 2 + data[at + 1] > len(data):
            return None
        by_code[data[at]] = data[at + 2 : at + 2 + data[at + 1]]
        at += 2 + data[at + 1]
    return by_code
