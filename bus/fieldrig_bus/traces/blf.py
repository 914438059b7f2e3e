"""The BLF format of Vector's CANoe and CANalyzer, for CAN; python-can and asammdf read it as well.

Objects are laid out by python-can's tables, and packed and read here (`blf_objects`): python-can's writer moves a
message that is earlier than the first one to its instant, rounds times to a quarter of a microsecond, and leaves out
the names of buses.  Times have nanoseconds; the start is in UTC, as python-can has it.  An error or state of a
controller is an error frame of SocketCAN, as python-can logs it; an injected fault is left out.
"""

import struct
from collections.abc import Iterable, Iterator
from itertools import chain
from typing import BinaryIO, Final

from fieldrig.clock import MS
from fieldrig.errors import UsageError
from fieldrig.traces.limits import from_1970
from fieldrig.traces.oddities import Oddities
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.codec import encode
from fieldrig_bus.can.frame import EXTENDED_MASK, FD_LENGTHS, STANDARD_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.can.socketcan_errors import notice_of
from fieldrig_bus.traces import blf_objects as layout
from fieldrig_bus.traces.beginning import beginning
from fieldrig_bus.traces.blf_objects import (
    BASE_SIZE,
    FILE_SIGNATURE,
    FIRST_DATE_NS,
    HEAD_SIZE,
    LARGEST_INSIDE,
    REMEDY,
    SIGNATURE,
    chunks,
    container,
    file_head,
    read_head,
)
from fieldrig_bus.traces.can_fields import Fields, fields_of, message_of, plain_message
from fieldrig_bus.traces.channels import BusNames, Channels
from fieldrig_bus.traces.error_capture import error_of, unknown_error
from fieldrig_bus.traces.plain_heads import HEAD_BYTES, PlainHeads

SUFFIXES = (".blf",)
FAMILIES = frozenset({"can"})
WRITES_BACK = True
CONTAINER_SIZE: Final = 128 * 1024
LEVEL: Final = 1
"""The level of compression: half the time of the usual level 6, for files that are a tenth larger."""

_HEADS: Final = struct.Struct("<4sHHLLLHHQ")  # OBJ_HEADER_BASE and OBJ_HEADER_V1 of python-can
_CLASSICAL: Final = struct.Struct("<4sHHLLLHHQHBBL8s")  # and CAN_MSG behind them
_PLAIN: Final = struct.Struct("<24sQH6s8s")
"""The same for a plain data frame: what is equal in all of them, instant, channel, what `_head_of` gives, data."""
_APP_TEXT, _APP_TEXT_STRUCT = 65, struct.Struct("<LLLL")  # source, reserved, length of the text, reserved
_CAN_ERROR: Final = 2
_CHANNEL: Final = struct.Struct("<H")
_REQUESTED: Final = 2
"""The direction of a request to send; 0 is received, 1 sent."""
_EVENTS: Final = frozenset({4, 5, 6, 31, 51, 65, 72, 74, 90, 92, 96, 115, 116, 128, 129, 131})
"""Statistics, triggers, variables, texts and states of the tools."""


def recognises(head: bytes) -> bool:
    return head.startswith(FILE_SIGNATURE)


# ---- reading


def read(file: BinaryIO, odd: Oddities | None = None) -> Iterator[TraceEntry]:
    """Yield the entries.  What is damaged or no CAN frame is odd; UsageError for a file that is no BLF."""
    odd = Oddities() if odd is None else odd
    odd.unit, odd.number = "object", 0
    reader = _Reader(read_head(file, odd).start_ns, odd)
    for chunk in chunks(file, odd):
        yield from reader.feed(chunk)
    reader.end()
    if len(odd) and not reader.found:
        raise UsageError("; ".join(map(str, odd)), REMEDY)


class _Reader:
    def __init__(self, start_ns: int, odd: Oddities) -> None:
        self._start_ns, self._odd = start_ns, odd
        self._names = BusNames()
        self._rest = b""
        self.found = 0

    def feed(self, chunk: bytes) -> Iterator[TraceEntry]:
        """Yield the messages that are complete with these bytes."""
        data, at = self._rest + chunk, 0
        odd, names, start_ns, size = self._odd, self._names, self._start_ns, len(data)
        unpack, whole, new = _CLASSICAL.unpack_from, _CLASSICAL.size, tuple.__new__
        while (found := data.find(SIGNATURE, at)) >= 0 and size - found >= BASE_SIZE:
            if found - at > 8:
                odd.report("bytes that are no objects are skipped")
            at = found
            if size - at >= whole:
                _, _, version, length, kind, unit, _, _, ticks, channel, flags, dlc, word, body = unpack(data, at)
                if kind in (1, 86) and version == 1 and flags <= 1 and dlc <= 8 and whole <= length <= size - at:
                    word = word & EXTENDED_MASK | (word & EXTENDED)
                    if word <= STANDARD_MASK or word & EXTENDED:
                        odd.number += 1
                        self.found += 1
                        time_ns = start_ns + (ticks * 10_000 if unit == 1 else ticks)
                        yield new(TraceEntry, (time_ns, names[channel], "can", "", plain_message(word, body[:dlc])))
                        at += length
                        continue
            _, _, _, length, kind = layout.OBJ_HEADER_BASE_STRUCT.unpack_from(data, at)
            if not BASE_SIZE <= length <= LARGEST_INSIDE:
                odd.report("bytes that are no objects are skipped", f": an object claims to have {length} bytes")
                at += len(SIGNATURE)
                continue
            if length > size - at:
                break
            odd.number += 1
            entry = self._entry(data[at : at + length], kind)
            if entry is not None:
                self.found += 1
                yield entry
            at += length
        if found < 0 and size - at > 8:
            odd.report("bytes that are no objects are skipped")
        self._rest = data[at if found >= 0 else max(at, size - 3) :]

    def end(self) -> None:
        """Report an object that is not whole."""
        if self._rest.strip(b"\0"):
            self._odd.report("the file is cut off")

    def _entry(self, data: bytes, kind: int) -> TraceEntry | None:
        _, head_size, version, _, _ = layout.OBJ_HEADER_BASE_STRUCT.unpack_from(data)
        struct_of = {1: layout.OBJ_HEADER_V1_STRUCT, 2: layout.OBJ_HEADER_V2_STRUCT}.get(version)
        make = _KINDS.get(kind)
        try:
            if struct_of is None or make is None:
                self._left_out(data, kind)
                return None
            unit, _, _, ticks = struct_of.unpack_from(data, BASE_SIZE)
            channel, message = make(data, BASE_SIZE + struct_of.size, head_size)
        except (struct.error, ValueError) as wrong:
            self._odd.report("frames that cannot be read are left out", f": {wrong}")
            return None
        if message is None:
            self._odd.report("requests to send are left out, as the frames follow them")
            return None
        time_ns = self._start_ns + (ticks * 10_000 if unit == 1 else ticks)
        return TraceEntry(time_ns, self._names[channel], "can", "", message)

    def _left_out(self, data: bytes, kind: int) -> None:
        if kind == _APP_TEXT:
            self._names.learn(data[BASE_SIZE:].decode("latin-1"))
        if kind not in _EVENTS:
            self._odd.report("objects that are no CAN frames are left out", f", of kind {kind}")


def _classical(data: bytes, at: int, head_size: int) -> tuple[int, bytes | None]:
    channel, flags, dlc, word, body = layout.CAN_MSG_STRUCT.unpack_from(data, at)
    if flags & ~layout.REMOTE_FLAG == _REQUESTED:
        return channel, None
    return channel, _message(word, bool(flags & layout.REMOTE_FLAG), body[: min(dlc, 8)], dlc)


def _fd(data: bytes, at: int, head_size: int) -> tuple[int, bytes | None]:
    values = layout.CAN_FD_MSG_STRUCT.unpack_from(data, at)
    channel, flags, dlc, word, _, _, fd_flags, valid, body = values
    if flags & ~layout.REMOTE_FLAG == _REQUESTED:
        return channel, None
    is_fd, is_remote = bool(fd_flags & layout.EDL), bool(flags & layout.REMOTE_FLAG)
    return channel, _message(word, is_remote, body[:valid], dlc, is_fd, bool(fd_flags & layout.BRS))


def _fd_64(data: bytes, at: int, head_size: int) -> tuple[int, bytes | None]:
    values = layout.CAN_FD_MSG_64_STRUCT.unpack_from(data, at)
    channel, dlc, valid, _, word, _, flags = values[:7]
    way, extra_at = values[12], values[13]
    if way == _REQUESTED:
        return channel, None
    begin = at + layout.CAN_FD_MSG_64_STRUCT.size
    # data that is not there is 0, as CANoe writes frames of zeros (python-can, issue 1905)
    body = data[begin : min(begin + valid, extra_at or len(data))].ljust(valid, b"\0")
    return channel, _message(word, bool(flags & 0x10), body, dlc, bool(flags & 0x1000), bool(flags & 0x2000))


def _message(
    word: int, is_remote: bool, data: bytes, dlc: int, is_fd: bool = False, is_switched: bool = False
) -> bytes | None:
    is_extended = bool(word & EXTENDED) or word & EXTENDED_MASK > STANDARD_MASK
    flagged = word & EXTENDED_MASK | is_extended * EXTENDED | is_remote * REMOTE
    if is_remote:
        return message_of(flagged, b"", FD_LENGTHS[dlc & 15])
    return message_of(flagged, data, is_fd=is_fd, is_switched=is_fd and is_switched)


def _error_frame(data: bytes, at: int, head_size: int) -> tuple[int, bytes | None]:
    channel, _, _, ecc, _, dlc, _, word, _, body = layout.CAN_ERROR_EXT_STRUCT.unpack_from(data, at)
    notice = notice_of(word & EXTENDED_MASK, body[: min(dlc, 8)]) if ecc == 0 and word else None
    return channel, encode(notice if notice is not None else error_of(ecc) if ecc else unknown_error())


def _oldest_error_frame(data: bytes, at: int, head_size: int) -> tuple[int, bytes | None]:
    return _CHANNEL.unpack_from(data, at)[0], encode(unknown_error())


_KINDS: Final = {
    layout.CAN_MESSAGE: _classical,
    layout.CAN_MESSAGE2: _classical,
    layout.CAN_FD_MESSAGE: _fd,
    layout.CAN_FD_MESSAGE_64: _fd_64,
    layout.CAN_ERROR_EXT: _error_frame,
    _CAN_ERROR: _oldest_error_frame,
}


# ---- writing


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int, odd: Oddities | None = None) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of messages."""
    first, rest = beginning(entry for entry in entries if entry.family == "can")
    odd = Oddities() if odd is None else odd
    start_ns = from_1970(start_unix_ns + min((entry.time_ns for entry in first), default=-start_unix_ns), odd)
    writer = _Writer(file, start_ns - start_ns % MS if start_ns >= FIRST_DATE_NS else 0, odd)
    heads = PlainHeads(_head_of)
    for time_ns, bus, _, _, message in chain(first, rest):
        head = heads[message[:HEAD_BYTES]]
        if head is not None and message[4] == len(message) - HEAD_BYTES:
            writer.add_plain(start_unix_ns + time_ns, bus, head, message[HEAD_BYTES:])
        elif (fields := fields_of(message)) is not None:
            writer.add(start_unix_ns + time_ns, bus, fields)
    writer.close()
    return writer.written


class _Writer:
    """A file that is written a container at a time.  Its header has the numbers of the end, so it is written twice."""

    def __init__(self, file: BinaryIO, start_ns: int, odd: Oddities) -> None:
        self._file, self._odd = file, odd
        self._start_ns = self._stop_ns = start_ns
        self._channels = Channels()
        self._waiting: list[bytes] = []
        self._size = 0
        self._inflated, self._written_bytes, self._objects = HEAD_SIZE, HEAD_SIZE, 0
        self.written = 0
        file.write(file_head(HEAD_SIZE, HEAD_SIZE, 0, 0, 0))

    def add_plain(self, time_ns: int, bus: str, head: bytes, data: bytes) -> None:
        ticks = time_ns - self._start_ns
        channel = self._channels.get(bus)
        if channel is None or ticks < 0:
            ticks, channel = self._place(time_ns, bus)
        self._waiting.append(_PLAIN.pack(_PLAIN_HEAD, ticks, channel, head, data))
        self._size += _CLASSICAL.size
        self.written += 1
        if time_ns > self._stop_ns:
            self._stop_ns = time_ns
        if self._size >= CONTAINER_SIZE:
            self._flush()

    def add(self, time_ns: int, bus: str, fields: Fields) -> None:
        """Add a message that is no plain data frame."""
        ticks, channel = self._place(time_ns, bus)
        self.written += 1
        self._stop_ns = max(self._stop_ns, time_ns)
        self._put(*_special(channel, fields, ticks))

    def _place(self, time_ns: int, bus: str) -> tuple[int, int]:
        """Return the instant in the file and the channel."""
        ticks = time_ns - self._start_ns
        if ticks < 0:
            self._odd.report("messages earlier than the first one get its time, as the format has no earlier")
            ticks = 0
        if self._channels.get(bus) is None:
            text = self._channels.add(bus).encode()
            self._put(_APP_TEXT, ticks, _APP_TEXT_STRUCT.pack(0, 0, len(text), 0) + text)
        return ticks, self._channels[bus]

    def _put(self, kind: int, ticks: int, body: bytes) -> None:
        size = _HEADS.size + len(body)
        head = _HEADS.pack(SIGNATURE, _HEADS.size, 1, size, kind, layout.TIME_ONE_NANS, 0, 0, ticks)
        self._append(head + body + bytes(size % 4))

    def _append(self, data: bytes) -> None:
        self._waiting.append(data)
        self._size += len(data)
        if self._size >= CONTAINER_SIZE:
            self._flush()

    def _flush(self) -> None:
        data = b"".join(self._waiting)
        self._objects += len(self._waiting)
        self._waiting.clear()
        packed = container(data, LEVEL)
        self._size = 0
        self._inflated += BASE_SIZE + layout.LOG_CONTAINER_STRUCT.size + len(data)
        self._written_bytes += len(packed)
        self._file.write(packed)

    def close(self) -> None:
        if self._waiting:
            self._flush()
        self._file.seek(0)
        times = (self._start_ns, self._stop_ns)
        self._file.write(file_head(self._written_bytes, self._inflated, self._objects, *times))


_PLAIN_HEAD: Final = _HEADS.pack(
    SIGNATURE, _HEADS.size, 1, _CLASSICAL.size, layout.CAN_MESSAGE, layout.TIME_ONE_NANS, 0, 0, 0
)[:24]


def _head_of(identifier: int, is_extended: bool, length: int) -> bytes:
    """Flags, length and identifier of a plain data frame."""
    return struct.pack("<BBL", 0, length, identifier | is_extended * EXTENDED)


def _special(channel: int, fields: Fields, ticks: int) -> tuple[int, int, bytes]:
    """Kind, instant and body of a remote frame, an FD frame or an error frame."""
    word, data, length, is_fd, is_switched = fields
    plain = word & EXTENDED_MASK | (word & EXTENDED)
    if word & ERROR:
        body = layout.CAN_ERROR_EXT_STRUCT.pack(channel, 0, 0, 0, 0, length, 0, plain, 0, data)
        return layout.CAN_ERROR_EXT, ticks, body
    if not is_fd:
        return layout.CAN_MESSAGE, ticks, layout.CAN_MSG_STRUCT.pack(channel, layout.REMOTE_FLAG, length, plain, data)
    fd_flags = layout.EDL | (layout.BRS if is_switched else 0)
    code = FD_LENGTHS.index(length)
    return (
        layout.CAN_FD_MESSAGE,
        ticks,
        layout.CAN_FD_MSG_STRUCT.pack(channel, 0, code, plain, 0, 0, fd_flags, length, data),
    )
