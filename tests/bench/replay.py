"""Recordings: an hour of the lab and a part of the machine played back in virtual time, and two long logs compared.

`python tests/bench/replay.py 3600` plays an hour of the machine.  Its recording is made meanwhile, in another process,
so that an hour needs no memory; times are those of the processor, as both share the host with others.
"""

import multiprocessing
import resource
import sys
import time
from collections.abc import Callable, Iterator
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from recorded_logs import recorded  # noqa: E402  found beside this file
from report import COMPARED, Report, progress  # noqa: E402

from fieldrig.bus import Delivery  # noqa: E402
from fieldrig.clock import MS, S  # noqa: E402
from fieldrig.config.rig_file import load  # noqa: E402
from fieldrig.traces import trace_files  # noqa: E402
from fieldrig.traces.trace import TraceEntry  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402
from fieldrig_bus.can import CanFrame  # noqa: E402
from fieldrig_bus.modbus import ModbusRequest  # noqa: E402
from fieldrig_devices.replay import diff, replay  # noqa: E402

CONFIGS = HERE.parents[1] / "configs"
HOUR_S = 3600
MACHINE_S = int(sys.argv[1]) if __name__ == "__main__" and sys.argv[1:] else 30
BATCH = 2_000
FRAMES = 500_000


def lab_master(rig: Rig) -> None:
    """A master that asks the lab four times a second by SDO and by Modbus, and sets its outputs."""
    link = rig.attach("plc").link
    rig.run_until(100 * MS)
    link("can0").send(CanFrame(0, bytes.fromhex("01 00")))
    for number in range(4 * HOUR_S):
        rig.run_for(250 * MS)
        link("can0").send(CanFrame(0x606, bytes.fromhex("40 00 10 00 00 00 00 00")))
        link("can0").send(CanFrame(0x205, (number & 0xFF).to_bytes(4, "little")))
        link("mb_tcp").send(ModbusRequest(1, bytes.fromhex("04 0000 0002"), number))


def machine_master(rig: Rig) -> None:
    """A client that starts the wrapper of the machine, and reads its packs ten times a second."""
    client = rig.attach("hmi").link("modbus")
    rig.run_until(5 * S)
    client.send(ModbusRequest(1, bytes.fromhex("05 8000 ff00")))
    for number in range(10 * (MACHINE_S - 5)):
        rig.run_for(100 * MS)
        client.send(ModbusRequest(1, bytes.fromhex("03 8001 0003"), number))


def wall_s(work: Callable[[], object]) -> float:
    begin_s = time.perf_counter()
    work()
    return time.perf_counter() - begin_s


def played(report: Report, name: str, master: Callable[[Rig], None], seconds: int, folder: Path) -> None:
    """Record a rig, and play the recording back from a file; the peer is the same master without a recording."""
    progress(f"replay: {seconds} s of {name}")
    file, path = CONFIGS / f"{name}.yaml", folder / f"{name}.jsonl"

    def alone() -> None:
        with Rig(load(file, ["time=virtual"])) as rig:
            master(rig)

    alone_s = wall_s(alone)
    log = recorded(file, master)
    trace_files.write(log, path)
    begin_s = time.perf_counter()
    result = replay(path, file)
    took_s = time.perf_counter() - begin_s
    assert result.is_same, result.differences[:3]
    report.add(
        f"{seconds} s of {name}, {len(log):,} messages, {result.played:,} played and {result.compared:,} compared",
        f"{took_s:.1f} s, {seconds / took_s:.0f} s/s; an hour in {HOUR_S / 60 * took_s / seconds:.1f} min",
        f"the rig with its master alone, {alone_s:.1f} s",
        took_s / alone_s,
    )


def recorder(end: Connection) -> None:
    """Record the machine, and send the messages and at last the processor time that it took."""
    batch: list[TraceEntry] = []

    def take(bus: Any, sent: Delivery[Any]) -> None:
        batch.append(TraceEntry(sent.time_ns, bus.name, bus.family, sent.sender, bus.encode(sent.message)))
        if len(batch) >= BATCH:
            end.send(batch)
            batch.clear()

    begin_s = time.process_time()
    with Rig(load(CONFIGS / "machine.yaml", ["time=virtual"])) as rig:
        rig.on_delivery(take)
        machine_master(rig)
    end.send(batch)
    end.send(time.process_time() - begin_s)


def machine_played(report: Report) -> None:
    """Play the machine back while it is recorded; the peer is the machine with its master, which records."""
    progress(f"replay: {MACHINE_S} s of the machine")
    here, there = multiprocessing.Pipe(duplex=False)
    process = multiprocessing.get_context("fork").Process(target=recorder, args=(there,))
    process.start()
    count, alone_s = 0, 0.0

    def log() -> Iterator[TraceEntry]:
        nonlocal count, alone_s
        while isinstance(received := here.recv(), list):
            count += len(received)
            yield from received
        alone_s = received

    begin_s = time.process_time()
    result = replay(log(), CONFIGS / "machine.yaml")
    took_s = time.process_time() - begin_s
    process.join()
    assert result.is_same, result.differences[:3]
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss // 1024
    report.add(
        f"{MACHINE_S} s of machine, {count:,} messages, {result.played:,} played and {result.compared:,} compared",
        f"{took_s:.1f} s of processor time, {MACHINE_S / took_s:.1f} s/s, {memory} MB",
        f"the rig with its master, which records it, {alone_s:.1f} s",
        took_s / alone_s,
    )


def compared(report: Report, folder: Path) -> None:
    """Compare two logs that differ in one frame; the peer is reading both."""
    progress(f"diff: {FRAMES:,} frames")
    frames = [bytes((0x81 + number, 1, 0, 0, 4)) + number.to_bytes(4) for number in range(16)]
    paths = [folder / "left.log", folder / "right.log"]
    for path, left_out in zip(paths, (None, FRAMES // 2), strict=True):
        entries = (
            TraceEntry(number * MS, "can0", "can", "", frames[number % 16])
            for number in range(FRAMES)
            if number != left_out
        )
        trace_files.write(entries, path)
    reading_s = wall_s(lambda: [sum(1 for _ in trace_files.read(path)) for path in paths])
    begin_s = time.perf_counter()
    result = diff(*paths)
    took_s = time.perf_counter() - begin_s
    assert sum(row.missing for row in result.rows) == 1
    report.add(
        f"diff of two logs of {FRAMES:,} frames, one of which is missing",
        f"{took_s:.1f} s, {2 * FRAMES / took_s:,.0f} frames/s",
        f"reading both, {reading_s:.1f} s",
        took_s / reading_s,
    )


def run() -> Report:
    from tempfile import TemporaryDirectory

    report = Report(
        "Recordings played back and compared",
        "This table shows how long it takes to play a recording back in virtual time, with all comparisons, and to find"
        " one missing frame. The first difference is read for a second time, with what was around it.",
        COMPARED,
    )
    with TemporaryDirectory() as folder:
        played(report, "lab", lab_master, HOUR_S, Path(folder))
        machine_played(report)
        compared(report, Path(folder))
    return report


if __name__ == "__main__":
    print(run().markdown())
