"""The log format of candump (`candump -L`), for CAN only; canplayer, log2asc, SavvyCAN and python-can read it.

A line has time in microseconds, bus, and frame, but no sender.  python-can reads the lines; they are written here,
because its writer omits the number of bytes that a remote frame requests.  Errors and changes of state are written as
error frames of SocketCAN, and skipped in reading; an injected fault has no frame and is left out.
"""

import io
from collections.abc import Iterable, Iterator
from typing import BinaryIO

from can.io import CanutilsLogReader

from fieldrig.errors import UsageError
from fieldrig.trace import TraceEntry
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame, check
from fieldrig_bus.can.linux_flags import BIT_RATE_SWITCH, ERROR
from fieldrig_bus.can.notices import BusState, CanError, Notice
from fieldrig_bus.can.socketcan_errors import error_frame

SUFFIX = ".log"
FAMILIES = frozenset({"can"})


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
    lines = _CountedLines(file, encoding="ascii", errors="replace")
    try:
        for message in CanutilsLogReader(lines):
            if message.is_error_frame:
                continue
            frame = check(
                CanFrame(
                    message.arbitration_id,
                    bytes(message.data),
                    is_extended=message.is_extended_id,
                    is_remote=message.is_remote_frame,
                    remote_length=message.dlc if message.is_remote_frame else 0,
                    is_fd=message.is_fd,
                    is_bit_rate_switched=message.bitrate_switch,
                )
            )
            yield TraceEntry(round(message.timestamp * 1e6) * 1000, str(message.channel), "can", "", encode(frame))
    except (ValueError, OverflowError, IndexError) as cause:  # the reader of python-can raises all of these
        what = f"line {lines.count} is not a line of candump: {cause}"
        raise UsageError(what, "write logs with `candump -L` or `fieldrig trace`") from cause


def _body(message: CanFrame | Notice) -> str | None:
    """The message as candump shows it; None for a message that candump can't represent."""
    if isinstance(message, CanError | BusState):
        kind, data = error_frame(message)
        return f"{kind | ERROR:08X}#{data.hex().upper()}"
    if not isinstance(message, CanFrame):
        return None
    identifier = f"{message.identifier:08X}" if message.is_extended else f"{message.identifier:03X}"
    if message.is_remote:
        return f"{identifier}#R{message.remote_length or ''}"
    if message.is_fd:
        return f"{identifier}##{BIT_RATE_SWITCH if message.is_bit_rate_switched else 0}{message.data.hex().upper()}"
    return f"{identifier}#{message.data.hex().upper()}"


class _CountedLines(io.TextIOWrapper):
    count = 0

    def __next__(self) -> str:  # type: ignore[override]  # as in TextIOWrapper, whose base has bytes
        line = super().__next__()
        self.count += 1
        return line
