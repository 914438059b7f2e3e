"""The Modbus messages in the TCP streams of a capture (Modbus messaging on TCP/IP V1.0b).

Each direction of a connection is put together by the sequence numbers (RFC 9293): segments come out of order, again,
or never, a segment has several ADUs or a part of one, and a capture may begin in the middle.  A connection carries
Modbus if a port is 502, or if its first segment is exactly one or several ADUs.  Where bytes are missing, the stream
goes on at the next thing that looks like the head of an ADU, and that is reported.

The exchange of a message is its transaction, with the number of its connection above it, as several clients use the
same transactions.

Memory is bounded: connections, segments that wait, and bytes of a message that is not complete.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Final

from fieldrig.traces.oddities import Oddities
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.traces.ip_packets import ACK, FIN, RST, SYN, Segment

PORT: Final = 502
MBAP: Final = struct.Struct("!HHHB")  # transaction, protocol 0, length of the rest, unit
MOST_STREAMS: Final = 20_000
MOST_WAITING: Final = 64
"""Segments of a stream that wait for an earlier one; then that one counts as lost."""
ENOUGH: Final = 2
"""Bare acknowledgements of bytes that are missing, after which they count as lost."""
MOST_BYTES: Final = 1 << 26
"""Bytes that wait in all streams."""
MOST_SEARCHED: Final = 2048
"""Bytes in which the beginning of a message is looked for."""
MOST_AHEAD: Final = 1 << 16
"""Bytes by which the first segment of a direction may be ahead of its first byte: a window without scaling."""
MOST_AGAIN: Final = 1 << 20
"""Bytes before the end of a connection that may be sent again after it."""
_HALF: Final = 1 << 31


@dataclass(slots=True)
class _Stream:
    """One direction of a connection."""

    is_request: bool
    sender: str
    connection: int
    """The number of the connection, from 0."""
    next: int | None = None
    """The sequence number that is expected; None before the first segment."""
    waiting: dict[int, Segment] = field(default_factory=dict)
    buffer: bytearray = field(default_factory=bytearray)
    is_lost: bool = True
    """True if it is not known where the next message begins."""
    has_ended: bool = False
    acknowledged: int = 0
    """The byte of the other direction that the sender waits for; 0 if it is not known."""
    confirmed: int = 0
    """How often the other end has acknowledged the bytes that are missing before those that wait."""

    def comes_again(self, segment: Segment) -> bool:
        """Return whether a segment that comes after the end is one of this connection, sent again."""
        return self.next is not None and (self.next - segment.sequence & 0xFFFF_FFFF) < MOST_AGAIN


Key = tuple[str, int, str, int]


class TcpStreams:
    """The streams of a capture.  Give it the segments of all packets in their order."""

    def __init__(self, odd: Oddities) -> None:
        self._odd = odd
        self._bytes = 0
        """Bytes that wait for earlier ones."""
        self._streams: dict[Key, _Stream | None] = {}
        """None for a direction of a connection without Modbus."""
        self._servers: dict[frozenset[tuple[str, int]], tuple[str, int]] = {}
        """The end of each connection that answers, as its opening has shown."""
        self._numbers: dict[frozenset[tuple[str, int]], int] = {}
        """The numbers of connections by their ends."""
        self._opened = 0

    def take(self, segment: Segment) -> Iterator[tuple[str, ModbusMessage]]:
        """Yield sender and message of each ADU that is complete with this segment."""
        key = (segment.source, segment.from_port, segment.target, segment.to_port)
        if segment.flags & SYN:
            self._open(key, segment)
            return
        known = self._streams.get(key)
        if known is not None:
            known.has_ended = known.has_ended or bool(segment.flags & RST)
            known.acknowledged = segment.acknowledged or known.acknowledged
        other = self._streams.get((*key[2:], *key[:2]))
        if other is not None and other.waiting and segment.flags & ACK:
            yield from self._confirm(other, segment)
        if not segment.data and not segment.missing:
            return
        if key not in self._streams or (known is not None and known.has_ended and not known.comes_again(segment)):
            self._streams[key] = self._stream_of(key, segment)
            if len(self._streams) > MOST_STREAMS:
                self._forget(next(iter(self._streams)))
        stream = self._streams[key]
        if stream is None:
            self._odd.report("TCP segments without Modbus are left out")
            return
        stream.acknowledged = segment.acknowledged or stream.acknowledged
        yield from self._feed(stream, segment)
        if segment.flags & (FIN | RST):
            yield from self._flush(stream)
            stream.has_ended = True

    def end(self) -> Iterator[tuple[str, ModbusMessage]]:
        """Yield what waits for segments that never came, at the end of the capture."""
        for stream in self._streams.values():
            if stream is not None:
                yield from self._flush(stream)
                if stream.buffer:
                    self._odd.report("messages at the end of the capture are cut off")

    def _open(self, key: Key, segment: Segment) -> None:
        """A connection begins: the end that sends a SYN without an acknowledgement is the client."""
        ends = frozenset({key[:2], key[2:]})
        if not segment.flags & ACK:
            self._servers[ends] = key[2:]
            self._numbers.pop(ends, None)  # the same ends, but another connection
            if len(self._servers) > MOST_STREAMS:
                del self._servers[next(iter(self._servers))]
        self._streams.pop(key, None)
        if PORT in (segment.from_port, segment.to_port):
            stream = self._new(key)
            stream.next, stream.is_lost = segment.sequence + 1 & 0xFFFF_FFFF, False
            self._streams[key] = stream

    def _stream_of(self, key: Key, segment: Segment) -> _Stream | None:
        peer = self._streams.get((*key[2:], *key[:2]))
        if peer is None and PORT not in (segment.from_port, segment.to_port) and not _are_adus(segment.data):
            return None
        stream = self._new(key)
        if peer is not None and peer.acknowledged and not _are_adus(segment.data):
            ahead = segment.sequence - peer.acknowledged & 0xFFFF_FFFF
            if ahead < MOST_AHEAD:  # its first bytes come later, and the peer has said which they are
                stream.next, stream.is_lost = peer.acknowledged, False
        return stream

    def _new(self, key: Key) -> _Stream:
        ends = frozenset({key[:2], key[2:]})
        server = self._servers.get(ends)
        if server is None:  # the capture begins later: 502, or else the lower port, is the server's
            server = min((key[:2], key[2:]), key=lambda end: (end[1] != PORT, end[1]))
        return _Stream(is_request=key[2:] == server, sender=f"{key[0]}:{key[1]}", connection=self._number(ends))

    def _number(self, ends: frozenset[tuple[str, int]]) -> int:
        if ends not in self._numbers:
            self._numbers[ends] = self._opened & 0xFFFF
            self._opened += 1
            if len(self._numbers) > MOST_STREAMS:
                del self._numbers[next(iter(self._numbers))]
        return self._numbers[ends]

    def _forget(self, key: Key) -> None:
        stream = self._streams.pop(key)
        if stream is not None:
            self._bytes -= sum(len(segment.data) for segment in stream.waiting.values())
        self._odd.report(f"a capture with more than {MOST_STREAMS} connections at a time loses the oldest ones")

    def _feed(self, stream: _Stream, segment: Segment) -> Iterator[tuple[str, ModbusMessage]]:
        if stream.next is None:
            stream.next = segment.sequence
        ahead = segment.sequence - stream.next & 0xFFFF_FFFF
        if 0 < ahead < _HALF:
            if segment.sequence not in stream.waiting:
                stream.waiting[segment.sequence] = segment
                self._bytes += len(segment.data)
            if len(stream.waiting) > MOST_WAITING or self._bytes > MOST_BYTES:
                yield from self._skip(stream)
            return
        self._append(stream, segment)
        yield from self._drained(stream)

    def _drained(self, stream: _Stream) -> Iterator[tuple[str, ModbusMessage]]:
        """Append the waiting segments that follow, and yield the messages that are complete."""
        while stream.waiting:
            assert stream.next is not None
            fitting = [begin for begin in stream.waiting if not 0 < begin - stream.next & 0xFFFF_FFFF < _HALF]
            if not fitting:
                break
            for begin in fitting:
                segment = stream.waiting.pop(begin)
                self._bytes -= len(segment.data)
                self._append(stream, segment)
        yield from self._messages(stream)

    def _append(self, stream: _Stream, segment: Segment) -> None:
        """Append what is new in a segment that does not begin after the expected byte."""
        assert stream.next is not None
        known = stream.next - segment.sequence & 0xFFFF_FFFF
        stream.buffer += segment.data[known:]
        new = len(segment.data) + segment.missing - known
        if new > 0:
            stream.next = stream.next + new & 0xFFFF_FFFF
        if segment.missing and new > 0:
            self._lose(stream)

    def _skip(self, stream: _Stream) -> Iterator[tuple[str, ModbusMessage]]:
        """Go on after a gap, with the earliest of the waiting segments."""
        assert stream.next is not None
        expected = stream.next
        stream.confirmed = 0
        stream.next = min(stream.waiting, key=lambda begin: begin - expected & 0xFFFF_FFFF)
        self._lose(stream)
        yield from self._drained(stream)

    def _confirm(self, stream: _Stream, segment: Segment) -> Iterator[tuple[str, ModbusMessage]]:
        """Go on after a gap whose bytes the other end has acknowledged, so that nothing but the capture has lost them.

        An answer is sure; a bare acknowledgement may be captured shortly before what it acknowledges.
        """
        assert stream.next is not None
        expected = stream.next
        first = min(begin - expected & 0xFFFF_FFFF for begin in stream.waiting)
        if first < segment.acknowledged - expected & 0xFFFF_FFFF < _HALF:
            stream.confirmed += 1
            if segment.data or stream.confirmed >= ENOUGH:
                yield from self._skip(stream)

    def _flush(self, stream: _Stream) -> Iterator[tuple[str, ModbusMessage]]:
        while stream.waiting:
            yield from self._skip(stream)

    def _lose(self, stream: _Stream) -> None:
        self._odd.report("bytes of a TCP stream are missing in the capture")
        stream.buffer.clear()
        stream.is_lost = True

    def _messages(self, stream: _Stream) -> Iterator[tuple[str, ModbusMessage]]:
        buffer, at = stream.buffer, 0
        make = ModbusRequest if stream.is_request else ModbusResponse
        while len(buffer) - at >= MBAP.size + 1:
            transaction, protocol, length, unit = MBAP.unpack_from(buffer, at)
            if stream.is_lost or protocol != 0 or not 2 <= length <= 254:
                stream.is_lost = True
                found = _next_head(buffer, at)
                if found != at and (found is not None or len(buffer) > MOST_SEARCHED):
                    self._odd.report("bytes that are no Modbus TCP are left out")
                if found is None:
                    at = max(at, len(buffer) - MOST_SEARCHED)
                    break
                at, stream.is_lost = found, False
                continue
            if len(buffer) - at < 6 + length:
                break
            exchange = stream.connection << 16 | transaction
            yield stream.sender, make(unit, bytes(buffer[at + MBAP.size : at + 6 + length]), exchange)
            at += 6 + length
        del buffer[:at]


def _next_head(buffer: bytearray, at: int) -> int | None:
    """Return where the next ADU begins: its end is that of the bytes, or the beginning of another one."""
    while len(buffer) - at > MBAP.size:
        end = at + 6 + int.from_bytes(buffer[at + 4 : at + 6], "big")
        if _is_head(buffer, at) and end <= len(buffer) and _is_head(buffer, end):
            return at
        found = buffer.find(b"\0\0", at + 3)  # the protocol of the next head
        if found < 0:
            return None
        at = found - 2
    return None


def _is_head(buffer: bytearray, at: int) -> bool:
    """Return whether these bytes may be the head of an ADU, as far as they are there."""
    head = buffer[at : at + 6]
    return not any(head[2:4]) and (len(head) < 6 or 2 <= int.from_bytes(head[4:], "big") <= 254)


def _are_adus(data: bytes) -> bool:
    """Return whether these bytes are exactly one or several ADUs with function codes."""
    at = 0
    while len(data) - at >= MBAP.size + 1:
        _, protocol, length, _ = MBAP.unpack_from(data, at)
        if protocol != 0 or not 2 <= length <= 254 or not data[at + MBAP.size] & 0x7F:
            return False
        at += 6 + length
    return at == len(data) > 0
