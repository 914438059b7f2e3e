"""The readers and writers of CAN logs here, against python-can's with messages of fieldrig at their other end.

python-can's are measured as fieldrig would use them: each `can.Message` becomes a `TraceEntry`, or is made from one.
The checks that would have to be put around them (places of errors, bounds) are left out, so their figures are the best
case.
"""

import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from tempfile import TemporaryDirectory

import can
from report import Report, progress
from trace_formats import FORMATS, made_log

from fieldrig.clock import US, S
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import read, write
from fieldrig_bus.can.acceptance import EXTENDED, REMOTE
from fieldrig_bus.can.frame import EXTENDED_MASK
from fieldrig_bus.can.linux_flags import ERROR
from fieldrig_bus.traces.can_fields import fields_of, message_of

FRAMES = 100_000


def read_by_python_can(path: Path) -> Iterator[TraceEntry]:
    with can.LogReader(path) as reader:
        for message in reader:
            word = message.arbitration_id | (EXTENDED if message.is_extended_id else 0)
            word |= (REMOTE if message.is_remote_frame else 0) | (ERROR if message.is_error_frame else 0)
            fd = message.is_fd, message.bitrate_switch
            data = message_of(word, bytes(message.data), message.dlc, *fd)
            if data is not None:
                yield TraceEntry(round(message.timestamp * 1e6) * US, f"can{message.channel or 0}", "can", "", data)


def write_by_python_can(entries: Iterable[TraceEntry], path: Path) -> int:
    count = 0
    with can.Logger(path) as logger:
        for entry in entries:
            fields = fields_of(entry.data)
            if fields is not None:
                word, data, length, is_fd, is_switched = fields
                count += 1
                logger.on_message_received(
                    can.Message(
                        entry.time_ns / S,
                        word & EXTENDED_MASK,
                        bool(word & EXTENDED),
                        bool(word & REMOTE),
                        bool(word & ERROR),
                        0,
                        length,
                        data,
                        is_fd,
                        True,
                        is_switched,
                    )
                )
    return count


def us_a_frame(work: Callable[[Path, Path], object], path: Path, target: Path) -> float:
    """Return the best of three rounds, in microseconds of processor time for each frame."""
    best = float("inf")
    for _ in range(3):
        target.unlink(missing_ok=True)
        start_s = time.process_time()
        work(path, target)
        best = min(best, time.process_time() - start_s)
    return best / FRAMES * 1e6


def run() -> Report:
    report = Report(
        "Readers and writers of CAN logs",
        f"This table shows what reading and writing {FRAMES:,} frames takes, in us of processor time a frame: here, "
        "and with python-can's reader or writer in its place, whose messages are converted. "
        "Its writer of SQLite has lost most of the rows that its figure stands for.",
        ("format", "read here", "read by python-can", "written here", "written by python-can"),
    )
    with TemporaryDirectory() as folder:
        log = Path(folder) / "all.log"
        made_log(log, FRAMES)
        entries = list(read(log))
        for ending in FORMATS:
            progress(f"reader and writer of {ending}")
            path, target = log.with_suffix(ending), Path(folder) / f"written{ending}"
            write(entries, path)
            report.add(
                ending,
                *(
                    f"{us_a_frame(work, path, target):.2f}"
                    for work in (
                        lambda path, _: deque(read(path), 0),
                        lambda path, _: deque(read_by_python_can(path), 0),
                        lambda _, target: write(entries, target),
                        lambda _, target: write_by_python_can(entries, target),
                    )
                ),
            )
    return report


if __name__ == "__main__":
    print(run().markdown())
