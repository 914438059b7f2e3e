"""The share of a cycle that Zenoh alone leaves: a process per drive, one put to all, one back from each.

    ring_floor.py SECONDS            the master: it measures, and prints a line of JSON for each line of its input
    ring_floor.py PLACE NUMBER       a drive

Sessions and scheduling are those of `ring.zenoh`; the messages are as long as an MDT and an AT of the benchmark.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final, Self

import zenoh
from report import percentile

from fieldrig.control import endpoint
from fieldrig.real.host import REALTIME_PRIORITY
from fieldrig_bus.ring.sercos.zenoh import RingZenoh
from fieldrig_bus.ring.transport.zenoh import MOST_BACK, PATIENT, TUNED

DRIVES: Final = 40
CYCLE_NS: Final = 4_000_000
OUT_BYTES: Final = 340
BACK_BYTES: Final = 24
SETTLING_CYCLES: Final = 500


def be_fast() -> None:
    if os.geteuid() == 0:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(REALTIME_PRIORITY))


def publisher(session: zenoh.Session, key: str) -> zenoh.Publisher:
    return session.declare_publisher(key, express=True, congestion_control=zenoh.CongestionControl.BLOCK)


def drive(place: str, number: str) -> None:
    be_fast()
    session = endpoint.open_session(
        {"mode": "peer", "listen/endpoints": [], "connect/endpoints": [place], **PATIENT, **TUNED}
    )
    put = publisher(session, f"back/{number}").put
    # Only the newest message is kept, because Zenoh blocks on a full channel, and no one here drops a slow reader.
    receive = session.declare_subscriber("all", zenoh.handlers.RingChannel(1)).recv
    rest = bytes(BACK_BYTES - 16)
    while True:
        put(receive().payload.to_bytes()[:8] + time.monotonic_ns().to_bytes(8, "little") + rest)


class Master:
    def __init__(self, place: str) -> None:
        self._session = session = endpoint.open_session({"mode": "peer", "listen/endpoints": [place], **TUNED})
        self._put = publisher(session, "all").put
        self._receive = session.declare_subscriber("back/*", zenoh.handlers.FifoChannel(MOST_BACK)).try_recv
        self._number = 0

    def is_answered_by_all(self) -> bool:
        return len(self._cycle(time.monotonic_ns() + 10 * CYCLE_NS)[1]) == DRIVES

    def run(self, cycles: int) -> tuple[int, list[float]]:
        """How many were kept, and the round trips of those, in us."""
        kept, trips_us = 0, []
        next_ns = time.monotonic_ns()
        for _ in range(cycles):
            next_ns += CYCLE_NS
            put_ns, done_ns = self._cycle(next_ns)
            if len(done_ns) == DRIVES:
                kept += 1
                trips_us.append((max(done_ns) - put_ns) / 1e3)
        return kept, trips_us

    def _cycle(self, until_ns: int) -> tuple[int, list[int]]:
        """When it was put, and when each of those that are in time was done."""
        self._number += 1
        head, put_ns = self._number.to_bytes(8, "little"), time.monotonic_ns()
        self._put(head + bytes(OUT_BYTES - 8))
        time.sleep(max(until_ns - time.monotonic_ns(), 0) / 1e9)
        done_ns = []
        while (sample := self._receive()) is not None:
            back = sample.payload.to_bytes()
            if back.startswith(head):
                done_ns.append(int.from_bytes(back[8:16], "little"))
        return put_ns, done_ns


def cpu_ns(pid: int) -> int:
    """The CPU time that all threads of a process have used, in nanoseconds."""
    return sum(int(task.read_text().split()[0]) for task in Path(f"/proc/{pid}/task").glob("*/schedstat"))


def outcome(master: Master, processes: Sequence[int], seconds: float) -> Mapping[str, float]:
    master.run(SETTLING_CYCLES)
    cycles = round(seconds * 1e9 / CYCLE_NS)
    before_ns, start_ns = sum(map(cpu_ns, processes)), time.monotonic_ns()
    kept, trips_us = master.run(cycles)
    cores = (sum(map(cpu_ns, processes)) - before_ns) / (time.monotonic_ns() - start_ns)
    return {
        "kept_percent": 100 * kept / cycles,
        "p50_us": percentile(trips_us or [0.0], 50),
        "p99_us": percentile(trips_us or [0.0], 99),
        "cores": cores,
    }


def measure(seconds: str) -> None:
    with tempfile.TemporaryDirectory(prefix="ring") as folder:
        place = f"unixsock-stream/{folder}/ring"
        master = Master(place)
        drives = [subprocess.Popen([sys.executable, __file__, place, str(number)]) for number in range(DRIVES)]
        try:
            be_fast()
            while not master.is_answered_by_all():
                pass
            for _ in sys.stdin:
                print(json.dumps(outcome(master, [os.getpid(), *(drive.pid for drive in drives)], float(seconds))))
                sys.stdout.flush()
        finally:
            for drive in drives:
                drive.kill()
                drive.wait()


class Floor:
    """The master as a process of its own."""

    def __init__(self, seconds: float) -> None:
        self._process = subprocess.Popen(
            [sys.executable, __file__, str(seconds)],
            env={**os.environ, **RingZenoh.environment},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
        )

    def __enter__(self) -> Self:
        return self

    def measured(self) -> Mapping[str, float]:
        """Measure the next seconds: `kept_percent`, `p50_us` and `p99_us` of the round trips, `cores`."""
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        self._process.stdin.write("again\n")
        self._process.stdin.flush()
        found: dict[str, float] = json.loads(self._process.stdout.readline())
        return found

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None
        self._process.stdin.close()
        self._process.wait()


if __name__ == "__main__":
    (measure if len(sys.argv) == 2 else drive)(*sys.argv[1:])
