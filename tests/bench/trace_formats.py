"""Converting CAN logs between each pair of formats, against python-can's own converter (`can.LogReader`, `can.Logger`).

Each conversion is a process of its own, so that its peak memory is its own; its processor time is counted, because a
busy host slows both alike.  FIELDRIG_BENCH_FRAMES sets another number of frames than five million.
"""

import os
import subprocess
import sys
from itertools import product
from pathlib import Path
from tempfile import TemporaryDirectory

from report import Report, progress

FRAMES = int(os.environ.get("FIELDRIG_BENCH_FRAMES", "5000000"))
FORMATS = (".log", ".asc", ".blf", ".trc", ".csv", ".db")
WITHOUT_PEER = (".pcap", ".pcapng", ".mf4")
LOSES_ROWS = ".db"
"""The target whose writer in python-can ends 0.25 s after it was stopped, with what it has written by then."""
LINE = "(%d.%06d) can0 %03X#%016X\n"
COB_IDS = (0x080, 0x181, 0x182, 0x201, 0x605, 0x585, 0x705)
OURS = """
count = write(read(Path({source!r})), Path({target!r}))
"""
PYTHON_CAN = """
with can.LogReader({source!r}) as reader, can.Logger({target!r}) as writer:
    count = 0
    for message in reader:
        writer.on_message_received(message)
        count += 1
"""
MEASURED = """
import resource, time
{imported}
begin = time.process_time()
{body}
print(count, time.process_time() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024)
"""
IMPORTED = {
    OURS: """
from pathlib import Path
from fieldrig.traces.formats import formats
from fieldrig.traces.trace_files import read, write
formats()
""",
    PYTHON_CAN: "import can",
}
"""The imports of a conversion, whose time is no part of it."""


def made_log(path: Path, frames: int) -> None:
    """Write a log of frames every half a millisecond."""
    with path.open("w", encoding="ascii") as file:
        for number in range(frames):
            second, part = divmod(number, 2_000)
            identifier = COB_IDS[number % len(COB_IDS)]
            file.write(
                LINE % (1_700_000_000 + second, part * 500, identifier, number * 0x9E3779B97F4A7C15 & (1 << 64) - 1)
            )


def converted(body: str, source: Path, target: Path) -> tuple[int, float, float]:
    """Return frames, seconds of processor time, and peak memory in MB of a conversion."""
    target.unlink(missing_ok=True)
    code = MEASURED.format(imported=IMPORTED[body], body=body.format(source=str(source), target=str(target)))
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    count, seconds, memory_mb = done.stdout.splitlines()[-1].split()  # asammdf prints its own progress
    return int(count), float(seconds), float(memory_mb)


def run() -> Report:
    report = Report(
        "CAN logs",
        f"Conversions of {FRAMES:,} frames between each pair of formats, against python-can's own converter in the same"
        " run: processor time, and the peak memory of the process.",
        ("conversion", "us a frame", "python-can", "ratio", "peak MB", "with a tenth of the frames"),
    )
    with TemporaryDirectory() as folder:
        sources: dict[str, Path] = {}
        small: dict[str, Path] = {}
        for of, name, frames in ((sources, "all", FRAMES), (small, "few", FRAMES // 10)):
            log = Path(folder) / f"{name}.log"
            made_log(log, frames)
            for ending in FORMATS:
                of[ending] = log.with_suffix(ending)
                if ending != ".log":
                    converted(OURS, log, of[ending])
        for source, target in product(FORMATS, (*FORMATS, *WITHOUT_PEER)):
            if target in WITHOUT_PEER and source != ".log":
                continue
            progress(f"{source} to {target}")
            path = Path(folder) / f"converted{target}"
            count, seconds, memory_mb = converted(OURS, sources[source], path)
            assert count == FRAMES
            _, _, few_mb = converted(OURS, small[source], path)
            has_peer = target not in WITHOUT_PEER and target != LOSES_ROWS
            peer_s = converted(PYTHON_CAN, sources[source], path)[1] if has_peer else None
            peer = "-" if peer_s is None else f"{peer_s / FRAMES * 1e6:.2f}"
            ratio = "-" if peer_s is None else f"{seconds / peer_s:.2f}"
            report.add(
                f"{source} to {target}",
                f"{seconds / FRAMES * 1e6:.2f}",
                peer,
                ratio,
                f"{memory_mb:.0f}",
                f"{few_mb:.0f}",
            )
    report.notes.append("python-can's writer of SQLite has no figure: it loses most of the rows that come at once.")
    return report


if __name__ == "__main__":
    print(run().markdown())
