"""Modbus RTU or ASCII in the bytes of a serial line: requests and responses, as a tap or a sniffer has them.

Source: Modbus over serial line V1.02, 2.4, 2.5.1 and 2.5.2.  The stamps of captures say little about silences, so a
frame of RTU is what has the length of its function and the right CRC, and one of ASCII what has a right LRC between a
colon and CR LF.  Requests and responses alternate on a line; a capture may say which side has sent a byte, and need
not.
"""

from collections.abc import Iterator
from typing import Final, NamedTuple

from fieldrig.clock import S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.framing_ascii import COLON, DIGITS
from fieldrig_bus.modbus.framing_ascii import LONGEST as MOST_DIGITS
from fieldrig_bus.modbus.framing_rtu import LONGEST, SHORTEST, crc16, request_size, response_size
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_bus.serial.codec import DATA
from fieldrig_devices.dialogues.modbus_dialogues import is_answer

LATEST_NS: Final = 10 * S
"""Time after which no answer comes any more."""
PAUSE_NS: Final = S // 2
"""Silence after which what is left of a frame is given up."""
IDENTIFICATION: Final = b"\x2b\x0e"
"""The functions of a response whose length only its last object says."""
CR_LF: Final = b"\r\n"
LONGEST_ASCII: Final = 1 + MOST_DIGITS + len(CR_LF)
MOST_SENDERS: Final = 8


class _Asked(NamedTuple):
    """The request that waits for its answer."""

    time_ns: int
    unit: int
    pdu: bytes


class RtuLine:
    """One line.  Each direction is put together alone."""

    def __init__(self) -> None:
        self._buffers: dict[str, bytearray] = {}
        self._last_ns = 0
        self._asked: _Asked | None = None
        self._exchange = 0
        self.frames = self.skipped = 0
        """Frames with a right CRC, and bytes in none of them."""

    def take(self, entry: TraceEntry) -> Iterator[TraceEntry]:
        """Yield the Modbus messages that are complete with an entry of a serial line."""
        if entry.data[:1] != bytes((DATA,)):
            return
        sender = entry.sender if entry.sender in self._buffers or len(self._buffers) < MOST_SENDERS else ""
        buffer = self._buffers.setdefault(sender, bytearray())
        if entry.time_ns - self._last_ns > PAUSE_NS:
            self._forget()
        self._last_ns = entry.time_ns
        buffer += entry.data[1:]
        while (size := self._size(buffer)) != 0:
            if size is None:
                del buffer[0]
                self.skipped += 1
                continue
            frame = bytes(buffer[:size])
            del buffer[:size]
            self.frames += 1
            if body := _ascii_body(frame):
                yield self._message(entry, body[0], body[1:], is_ascii=True)
            else:
                yield self._message(entry, frame[0], frame[1:-2], is_ascii=False)

    def _forget(self) -> None:
        for buffer in self._buffers.values():
            self.skipped += len(buffer)
            buffer.clear()

    def _size(self, buffer: bytearray) -> int | None:
        """Return the size of the frame at the beginning; 0 if more bytes may complete one, None if there is none."""
        if len(buffer) < SHORTEST:
            return 0
        if buffer[0] == COLON and (ascii_size := _ascii_size(buffer)) is not None:
            return ascii_size
        head = bytes(buffer[:LONGEST])
        sizes = {size for size_of in (response_size, request_size) if (size := size_of(head)) is not None}
        whole = [size for size in sizes if SHORTEST <= size <= len(buffer) and _is_right(bytes(buffer[:size]))]
        if whole:
            return max(whole)
        is_open = head[1:3] == IDENTIFICATION and len(head) < LONGEST and response_size(head) is None
        return 0 if is_open or any(len(buffer) < size <= LONGEST for size in sizes) else None

    def _message(self, entry: TraceEntry, unit: int, pdu: bytes, *, is_ascii: bool) -> TraceEntry:
        asked = self._asked
        is_late = asked is not None and entry.time_ns - asked.time_ns > LATEST_NS
        if asked is not None and not is_late and unit == asked.unit and is_answer(asked.pdu, pdu):
            self._asked = None
            message: ModbusRequest | ModbusResponse = ModbusResponse(unit, pdu, self._exchange)
        else:
            self._exchange += 1
            self._asked = _Asked(entry.time_ns, unit, pdu) if unit else None
            message = ModbusRequest(unit, pdu, self._exchange, LineState(is_ascii=is_ascii))
        return TraceEntry(entry.time_ns, entry.bus, "modbus", entry.sender, encode(message))


def _ascii_size(buffer: bytearray) -> int | None:
    """Return the size of the ASCII frame at the beginning; 0 if more may come, None if what begins with it is none."""
    end = buffer.find(CR_LF, 1, LONGEST_ASCII)
    if end >= 0:
        size = end + len(CR_LF)
        return size if _ascii_body(bytes(buffer[:size])) else None
    digits = bytes(buffer[1:]).removesuffix(CR_LF[:1])
    return 0 if len(buffer) < LONGEST_ASCII and set(digits) <= DIGITS else None


def _ascii_body(frame: bytes) -> bytes:
    """Return unit and PDU of a whole ASCII frame with a right LRC; empty for anything else."""
    digits = frame[1 : -len(CR_LF)]
    if frame[:1] != bytes((COLON,)) or not frame.endswith(CR_LF) or len(digits) % 2 or not set(digits) <= DIGITS:
        return b""
    body = bytes.fromhex(digits.decode("ascii"))
    return body[:-1] if len(body) >= 3 and sum(body) & 0xFF == 0 else b""


def _is_right(frame: bytes) -> bool:
    return crc16(frame[:-2]) == int.from_bytes(frame[-2:], "little")
