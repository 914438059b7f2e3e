"""The objects of a BLF file of Vector's tools, one by one, in bounded memory.

There is no public specification; the layouts are those that python-can has (`can.io.blf`), which is not imported here,
because it imports asammdf and numpy where they are installed, for half a second.  A file begins with a header
and goes on with objects.  Most are containers with compressed bytes, which joined together are objects again, so one
may begin in a container and end in the next.

A length is never trusted: an object that claims too much is skipped up to the next signature.  python-can's reader
allocates what a length says, and ends at a damaged object.
"""

import struct
import zlib
from collections.abc import Iterator
from datetime import UTC, datetime
from typing import BinaryIO, Final, NamedTuple

from fieldrig.clock import MS, S
from fieldrig.errors import UsageError
from fieldrig.traces.oddities import Oddities

FILE_HEADER_STRUCT: Final = struct.Struct("<4sLBBBBBBBBQQLL8H8H")
"""Signature, size, application and versions, size of the file, inflated size, objects, start and stop (SYSTEMTIME)."""
FILE_HEADER_SIZE: Final = 144
OBJ_HEADER_BASE_STRUCT: Final = struct.Struct("<4sHHLL")
"""Signature, size and version of the header, size and kind of the object."""
OBJ_HEADER_V1_STRUCT: Final = struct.Struct("<LHHQ")
OBJ_HEADER_V2_STRUCT: Final = struct.Struct("<LBxHQ8x")
"""Unit of time, two words that do not matter, instant."""
LOG_CONTAINER: Final = 10
LOG_CONTAINER_STRUCT: Final = struct.Struct("<H6xL4x")
"""Compression, inflated size."""
TIME_ONE_NANS: Final = 2
CAN_MESSAGE, CAN_ERROR_EXT, CAN_MESSAGE2, CAN_FD_MESSAGE, CAN_FD_MESSAGE_64 = 1, 73, 86, 100, 101
CAN_MSG_STRUCT: Final = struct.Struct("<HBBL8s")
"""Channel, flags, DLC, identifier, data."""
CAN_FD_MSG_STRUCT: Final = struct.Struct("<HBBLLBBB5x64s")
"""Channel, flags, DLC, identifier, time of the frame, bits, flags of FD, valid bytes, data."""
CAN_FD_MSG_64_STRUCT: Final = struct.Struct("<BBBBLLLLLLLHBBL")
"""Channel, DLC, valid bytes, tries, identifier, time, flags; place 12 is the direction, 13 the end of the data."""
CAN_ERROR_EXT_STRUCT: Final = struct.Struct("<HHLBBBxLLH2x8s")
"""Channel, length, flags, error code capture, position, DLC, time, identifier, more flags, data."""
REMOTE_FLAG: Final = 0x80
EDL, BRS = 0x1, 0x2
SIGNATURE: Final = b"LOBJ"
FILE_SIGNATURE: Final = b"LOGG"
REMEDY: Final = "expected a log of CANoe, CANalyzer, python-can or `fieldrig trace`"
LARGEST: Final = 1 << 24
"""Bytes of an object, at most; containers have 128 kB as a rule."""
LARGEST_INSIDE: Final = 1 << 20
"""Bytes of an object that is no container, at most; those of CAN have below 200."""
BASE_SIZE: Final = OBJ_HEADER_BASE_STRUCT.size
NO_COMPRESSION, ZLIB_DEFLATE = 0, 2


class Head(NamedTuple):
    start_ns: int
    """The time of day at instant 0 of the objects; 0 if the file has none."""


def read_head(file: BinaryIO, odd: Oddities) -> Head:
    """Read the header.  UsageError if the file does not begin with one."""
    data = file.read(FILE_HEADER_STRUCT.size)
    if len(data) < FILE_HEADER_STRUCT.size or not data.startswith(FILE_SIGNATURE):
        raise UsageError(
            "the file is empty" if not data else "the file does not begin with the header of a BLF", REMEDY
        )
    header = FILE_HEADER_STRUCT.unpack(data)
    rest = header[1] - FILE_HEADER_STRUCT.size
    if not 0 <= rest <= LARGEST:
        raise UsageError(f"the header claims to have {header[1]} bytes, and {FILE_HEADER_SIZE} are usual", REMEDY)
    file.read(rest)
    return Head(_start_ns(header[14:22], odd))


def _start_ns(start: tuple[int, ...], odd: Oddities) -> int:
    """Return the instant of a SYSTEMTIME, which is taken for UTC as by python-can."""
    year, month, _, day, hour, minute, second, ms = start
    if not any(start):
        return 0
    try:
        return int(datetime(year, month, day, hour, minute, second, tzinfo=UTC).timestamp()) * S + ms * MS
    except ValueError as wrong:
        odd.report("the date is none, and times count from 0", f": {wrong}")
        return 0


def chunks(file: BinaryIO, odd: Oddities) -> Iterator[bytes]:
    """Yield the bytes of the objects inside containers, and of those beside them, in pieces of bounded size."""
    while True:
        head = file.read(BASE_SIZE)
        if not head:
            return
        if len(head) < BASE_SIZE:
            odd.report("the file is cut off", f", at byte {file.tell()}")
            return
        signature, _, _, size, kind = OBJ_HEADER_BASE_STRUCT.unpack(head)
        if signature != SIGNATURE or not BASE_SIZE <= size <= LARGEST:
            odd.report("bytes that are no objects are skipped", _why(signature, size, file.tell()))
            if not _resynchronise(file, head, odd):
                return
            continue
        body = file.read(size - BASE_SIZE)
        if len(body) < size - BASE_SIZE:
            odd.report("the file is cut off", f", at byte {file.tell()}")
        yield from _inside(kind, head, body, odd)
        file.read(size % 4)


def _why(signature: bytes, size: int, at: int) -> str:
    claim = f": an object claims to have {size} bytes" if signature == SIGNATURE else ""
    return f", at byte {at - BASE_SIZE}{claim}"


def _inside(kind: int, head: bytes, body: bytes, odd: Oddities) -> Iterator[bytes]:
    if kind != LOG_CONTAINER:  # files that are not compressed may have their objects side by side
        yield head + body
        return
    if len(body) < LOG_CONTAINER_STRUCT.size:
        odd.report("containers that cannot be read are left out")
        return
    method, _ = LOG_CONTAINER_STRUCT.unpack_from(body)
    data = body[LOG_CONTAINER_STRUCT.size :]
    if method == NO_COMPRESSION:
        yield data
    elif method == ZLIB_DEFLATE:
        yield from _inflated(data, odd)
    else:
        odd.report("containers that cannot be read are left out", f": there is no compression {method}")


def _inflated(data: bytes, odd: Oddities) -> Iterator[bytes]:
    """Yield what is compressed in these bytes, as far as they are whole."""
    inflate = zlib.decompressobj()
    try:
        while data and not inflate.eof:
            yield inflate.decompress(data, LARGEST_INSIDE)
            data = inflate.unconsumed_tail
    except zlib.error as wrong:
        odd.report("containers that cannot be read are left out", f": {wrong}")


_PIECE: Final = 1 << 20
_UNWRITTEN: Final = bytes(_PIECE)
"""A piece of room on the disk that was never written; it is not searched, only compared."""
_MOST_UNWRITTEN: Final = 64
"""Such pieces in a row after which nothing more is expected, as a disk takes seconds for each gigabyte of them."""


def _resynchronise(file: BinaryIO, seen: bytes, odd: Oddities) -> bool:
    """Go to the next signature after the first of these bytes, which the file has just given.  False without one."""
    rest, unwritten = seen[1:], 0
    while True:
        at = rest.find(SIGNATURE)
        if at >= 0:
            file.seek(at - len(rest), 1)
            return True
        while (more := file.read(_PIECE)) == _UNWRITTEN and unwritten < _MOST_UNWRITTEN:
            rest, unwritten = _UNWRITTEN[:3], unwritten + 1
        if more == _UNWRITTEN:
            odd.report("the rest of the file is zeros", f", as the {unwritten} MiB before byte {file.tell()} are")
            return False
        if not more:
            return False
        rest = rest[-3:] + more


FIRST_DATE_NS: Final = 631_152_000 * S
"""1990, before which python-can writes no date; then the objects have their instants from 0."""


def systemtime(time_ns: int) -> tuple[int, ...]:
    """Return a SYSTEMTIME, as python-can writes it; zeros for an instant that is no time of day."""
    if time_ns < FIRST_DATE_NS:
        return (0,) * 8
    day = datetime.fromtimestamp(time_ns // S, tz=UTC)
    return day.year, day.month, day.isoweekday() % 7, day.day, day.hour, day.minute, day.second, time_ns % S // MS


HEAD_SIZE: Final = FILE_HEADER_SIZE
_PADDING: Final = struct.pack(f"{FILE_HEADER_SIZE - FILE_HEADER_STRUCT.size}x")


def file_head(size: int, inflated: int, objects: int, start_ns: int, stop_ns: int) -> bytes:
    """Return the header of a file; 5 is the application that python-can names."""
    numbers = (size, inflated, objects, 0)
    times = (*systemtime(start_ns), *systemtime(stop_ns))
    return (
        FILE_HEADER_STRUCT.pack(FILE_SIGNATURE, FILE_HEADER_SIZE, 5, 0, 0, 0, 2, 6, 8, 1, *numbers, *times) + _PADDING
    )


def container(data: bytes, level: int) -> bytes:
    """Return a container with these bytes, compressed."""
    packed = zlib.compress(data, level)
    size = BASE_SIZE + LOG_CONTAINER_STRUCT.size + len(packed)
    head = OBJ_HEADER_BASE_STRUCT.pack(SIGNATURE, BASE_SIZE, 1, size, LOG_CONTAINER)
    return head + LOG_CONTAINER_STRUCT.pack(ZLIB_DEFLATE, len(data)) + packed + bytes(size % 4)
