"""MBAP: the seven bytes before a PDU on TCP.

Source: Modbus messaging on TCP/IP implementation guide V1.0b, 3.1.3 and 4.2.2.  A message with a protocol id other than
0 is dropped.  A length that no Modbus message has (over 254) means that the stream is out of step and nothing after it
can be understood: the connection has to be closed.
"""

import struct
from typing import Final

LONGEST: Final = 254  # the length field counts unit and PDU
HEADER: Final = struct.Struct(">HHHB")  # transaction, protocol, length, unit

_unpack, _pack = HEADER.unpack_from, HEADER.pack


def tcp_frame(transaction: int, unit: int, pdu: bytes) -> bytes:
    return _pack(transaction, 0, len(pdu) + 1, unit) + pdu


class MbapFramer:
    def __init__(self) -> None:
        self._rest = b""
        self.dropped = 0
        self.is_lost = False
        """True if the stream is out of step; no more messages follow."""

    def end_of_first(self, data: bytes) -> int:
        """Return how many bytes of `data` complete the first message; all of them if none is complete."""
        start = self._rest + data[: HEADER.size]
        if len(start) < HEADER.size:
            return len(data)
        length: int = _unpack(start)[2]
        return min(max(6 + length - len(self._rest), 1), len(data))

    def feed(self, data: bytes) -> list[tuple[int, int, bytes]]:
        """Transaction, unit and PDU of every message that `data` completes."""
        if self._rest:
            data = self._rest + data
            self._rest = b""
        messages: list[tuple[int, int, bytes]] = []
        at, size = 0, len(data)
        if size > 7:  # one complete message and nothing else: the most common case
            transaction, protocol, length, unit = _unpack(data, 0)
            if size == 6 + length and protocol == 0 and length <= LONGEST and not self.is_lost:
                return [(transaction, unit, data[7:])]
        while size - at > 6 and not self.is_lost:
            transaction, protocol, length, unit = _unpack(data, at)
            end = at + 6 + length
            if length > LONGEST and protocol == 0:
                self.is_lost = True
                return messages
            if end > size:
                break
            if protocol == 0 and length > 1:
                messages.append((transaction, unit, data[at + 7 : end]))
            else:
                self.dropped += 1
            at = end
        if at < size and not self.is_lost:
            self._rest = data[at:]
        return messages
