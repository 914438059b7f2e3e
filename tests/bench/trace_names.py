"""Logs by name: frames a second into rows and into statistics, against cantools decoding the same PDOs.

The log is that of eight drives with a cycle of 2 ms, an SDO read in each cycle, and heartbeats; no two PDOs are alike.
"""

import random
import resource
import subprocess
import sys
import time
from collections.abc import Callable, Iterable
from pathlib import Path
from tempfile import TemporaryDirectory

import cantools.database
from cantools.database.can import Database, Message, Signal
from report import Report, progress

from fieldrig.clock import MS, US
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.can.codec import decode, encode
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.cia402.single.own_objects import EDS
from fieldrig_devices.log_stats.log_stats import LogStats
from fieldrig_devices.named_logs.named_log import NamedLog
from fieldrig_devices.named_logs.rows import Rows

FRAMES = 200_000
NODES = range(1, 9)
STATUS_WORD = bytes.fromhex("37 06")
READ, VALUE = bytes.fromhex("40 41 60 00 00 00 00 00"), bytes.fromhex("4B 41 60 00 37 06 00 00")
TPDO_3, RPDO_3 = 0x380, 0x400
"""Statusword with the actual position, and controlword with the target position."""


def log_of_drives() -> list[TraceEntry]:
    chance, found, now_ns = random.Random(1), list[TraceEntry](), 0

    def add(after_ns: int, identifier: int, data: bytes = b"") -> None:
        found.append(TraceEntry(now_ns + after_ns, "can0", "can", "", encode(CanFrame(identifier, data))))

    while len(found) < FRAMES:
        add(0, 0x080)
        for node in NODES:
            position = chance.randbytes(4)
            add(node * 10 * US, TPDO_3 + node, STATUS_WORD + position)
            add(node * 10 * US + US, RPDO_3 + node, b"\x0f\x00" + position)
        node = NODES[now_ns // (2 * MS) % len(NODES)]
        add(MS, 0x600 + node, READ)
        add(MS + 500 * US, 0x580 + node, VALUE)
        if now_ns % (100 * MS) == 0:
            for beating in NODES:
                add(MS + 600 * US + beating, 0x700 + beating, b"\x05")
        now_ns += 2 * MS
    return found[:FRAMES]


def database() -> Database:
    """Return the PDOs of the drives for cantools, with the same fields."""
    messages = [
        Message(base + node, f"{name}_{node}", 6, [Signal(word, 0, 16), Signal(position, 16, 32, is_signed=True)])
        for node in NODES
        for base, name, word, position in (
            (TPDO_3, "TPDO_3", "Statusword", "Position_actual_value"),
            (RPDO_3, "RPDO_3", "Controlword", "Target_position"),
        )
    ]
    return cantools.database.Database(messages)


def by_cantools(entries: Iterable[TraceEntry], known: Database) -> int:
    """Decode the PDOs among the frames; the others have no message."""
    identifiers = {message.frame_id for message in known.messages}
    count = 0
    for entry in entries:
        frame = decode(entry.data)
        if isinstance(frame, CanFrame) and frame.identifier in identifiers:
            known.decode_message(frame.identifier, frame.data)
        count += 1
    return count


def per_second(work: Callable[[], int]) -> float:
    """Return the best of three rounds, in frames for each second of CPU time."""
    best = 0.0
    for _ in range(3):
        start_s = time.process_time()
        count = work()
        best = max(best, count / (time.process_time() - start_s))
    return best


def commands(folder: Path, entries: list[TraceEntry], known: Database) -> tuple[float, float]:
    """Return the frames for each second of CPU time of `fieldrig trace show` and of `cantools decode`."""
    log, dbc = folder / "log.log", folder / "log.dbc"
    write(entries, log)
    dbc.write_text(known.as_dbc_string(), encoding="utf-8")
    programs = Path(sys.executable).parent
    described = [word for node in NODES for word in ("--eds", f"{node}={EDS}")]
    ours = [str(programs / "fieldrig"), "trace", "show", str(log), *described]
    theirs = [str(programs / "cantools"), "decode", "--single-line", str(dbc)]
    return len(entries) / cpu_s(ours, log), len(entries) / cpu_s(theirs, log)


def cpu_s(command: list[str], log: Path) -> float:
    """Return the CPU time of a program that reads the log, and whose output is thrown away."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    with log.open("rb") as file:
        subprocess.run(command, stdin=file, stdout=subprocess.DEVNULL, check=True)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def run() -> Report:
    report = Report(
        "Logs by name",
        f"This table shows how fast a log of {FRAMES:,} frames is read by name: PDOs, SDO transfers and heartbeats of "
        "eight drives with an EDS.",
        ("quantity", "measured", "compared with", "ratio"),
    )
    progress("logs by name")
    entries, names, known = log_of_drives(), NamedLog(dict.fromkeys(NODES, EDS)), database()

    def rows() -> int:
        for row in Rows(names).of(entries):
            assert row.words
        return len(entries)

    def stats() -> int:
        counted = LogStats(names)
        counted.read(entries)
        return counted.count

    peer = per_second(lambda: by_cantools(entries, known))
    for what, work in (
        ("frames a second into rows of `trace show`", rows),
        ("into the figures of `trace stats`", stats),
    ):
        measured = per_second(work)
        report.add(what, f"{measured:,.0f}/s", f"values by cantools, PDOs only: {peer:,.0f}/s", measured / peer)
    with TemporaryDirectory() as folder:
        ours, theirs = commands(Path(folder), entries, known)
    report.add("lines of the whole command `fieldrig trace show`", f"{ours:,.0f}/s",
               f"`cantools decode`, PDOs only: {theirs:,.0f}/s", ours / theirs)  # fmt: skip
    return report


if __name__ == "__main__":
    print(run().markdown())
