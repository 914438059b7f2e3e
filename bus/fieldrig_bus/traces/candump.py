"""The log format of candump (`candump -L`), for CAN only; canplayer, log2asc, SavvyCAN and python-can read it.

A line has time in microseconds, bus, and frame, but no sender.  Lines are written and read here: python-can's writer
omits the number of bytes that a remote frame requests, and its reader takes error frames of most classes, and data of
half a byte, for frames of the bus.  Errors and changes of state are error frames of SocketCAN; an injected fault has no
frame and is left out.
"""

from collections.abc import Iterable, Iterator
from typing import BinaryIO, Final

from fieldrig.errors import UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can.codec import decode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.notices import BusState, CanError, Notice
from fieldrig_bus.can.socketcan_errors import error_frame
from fieldrig_bus.traces.candump_lines import parse, says_nothing

SUFFIX = ".log"
FAMILIES = frozenset({"can"})
BYTE_ORDER_MARK: Final = "\ufeff"
REMEDY: Final = "write logs with `candump -L` or `fieldrig trace`, or take the line out"


def write(entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int) -> int:
    """Write entries; `start_unix_ns` is the time of day at their instant 0.  Returns the number of lines."""
    written = 0
    for entry in entries:
        body = _body(decode(entry.data)) if entry.family == "can" else None
        if body is not None:
            seconds, microseconds = divmod((start_unix_ns + entry.time_ns) // 1000, 1_000_000)
            file.write(f"({seconds}.{microseconds:06}) {entry.bus} {body}\n".encode())
            written += 1
    return written


def read(file: BinaryIO) -> Iterator[TraceEntry]:
    """Entries with the time of day as their instant.  UsageError, with the line, for a file that is not such a log."""
    time_ns = 0
    for number, data in enumerate(file, 1):
        line = data.decode(errors="replace").removeprefix(BYTE_ORDER_MARK)
        if says_nothing(line):
            continue
        try:
            entry = parse(line)
        except ValueError as wrong:
            how = "is cut off" if not line.endswith("\n") else "is not a line of candump"
            raise UsageError(f"line {number} {how}: {wrong}", REMEDY) from wrong
        time_ns = time_ns if entry.time_ns is None else entry.time_ns
        if entry.message is not None:
            yield TraceEntry(time_ns, entry.bus, "can", "", entry.message)


def _body(message: CanFrame | Notice) -> str | None:
    """The message as candump shows it; None for a message that candump cannot represent."""
    if isinstance(message, CanError | BusState):
        error_class, data = error_frame(message)
        return f"{error_class | ERROR:08X}#{data.hex().upper()}"
    if not isinstance(message, CanFrame):
        return None
    identifier = f"{message.identifier:08X}" if message.is_extended else f"{message.identifier:03X}"
    if message.is_remote:
        return f"{identifier}#R{message.remote_length or ''}"
    if message.is_fd:
        return f"{identifier}##{BIT_RATE_SWITCH if message.is_bit_rate_switched else 0}{message.data.hex().upper()}"
    return f"{identifier}#{message.data.hex().upper()}"
