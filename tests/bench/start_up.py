"""The time from `fieldrig up` to ready, and the cost of a process: the lab with a process per device and hub."""

import json
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from report import COMPARED, Report, progress

from fieldrig.testing import free_port

ROOT = Path(__file__).parents[2]
FIELDRIG = str(Path(sys.executable).with_name("fieldrig"))
STARTS = 5
FIXTURE = """
import sys, time
start_s = time.perf_counter()
from pathlib import Path
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
imported_s = time.perf_counter()
with Rig(load(Path(sys.argv[1]), ["time=virtual"])):
    print(time.perf_counter() - imported_s, imported_s - start_s)
"""


def start_lab() -> tuple[float, list[float]]:
    """Seconds to ready, and the resident MB of each process."""
    control = f"tcp/127.0.0.1:{free_port()}"
    with tempfile.TemporaryDirectory(prefix="fieldrig-") as run:
        changes = [
            f"control={control}",
            f"run={run}",
            f"buses.can0.socketcand=127.0.0.1:{free_port()}",
            f"buses.mb_tcp.listen=127.0.0.1:{free_port()}",
        ]
        arguments = [FIELDRIG, "up", "configs/lab.yaml", *(f"--set={change}" for change in changes)]
        start_s = time.perf_counter()
        with subprocess.Popen(arguments, cwd=ROOT, stdout=subprocess.PIPE, text=True) as lab:
            assert lab.stdout is not None
            while not next(lab.stdout).startswith("ready"):
                pass
            ready_s = time.perf_counter() - start_s
            status = subprocess.run(
                [FIELDRIG, "status", "--json", f"--control={control}"], capture_output=True, text=True, check=True
            )
            lab.terminate()
            lab.stdout.read()
    return ready_s, [process["memory_mb"] for process in json.loads(status.stdout)["processes"].values()]


def fixture_rig() -> tuple[float, float]:
    """Seconds from a file with 4 devices to a rig that stands, in a fresh interpreter; and of the imports before."""
    lab = str(ROOT / "configs/lab.yaml")
    done = subprocess.run([sys.executable, "-c", FIXTURE, lab], capture_output=True, text=True, check=True, cwd=ROOT)
    ready_s, import_s = map(float, done.stdout.split())
    return ready_s, import_s


def run() -> Report:
    report = Report(
        "Start-up and memory",
        f"This table shows how long a rig takes until it is ready, as the median of {STARTS} starts, and its memory.",
        COMPARED,
    )
    progress("start-up: the lab")
    starts = [start_lab() for _ in range(STARTS)]
    ready_s = statistics.median(ready_s for ready_s, _ in starts)
    report.add("time from `fieldrig up` to ready, lab", f"{ready_s:.2f} s", "2 s", f"{ready_s / 2:.2f}")
    memory_mb = [each for _, process_mb in starts for each in process_mb]
    report.add("resident memory of a device process", f"{statistics.median(memory_mb):.0f} MB",
               "a Zenoh session alone: 24 MB", f"{statistics.median(memory_mb) / 24:.1f}")  # fmt: skip
    progress("start-up: a fixture-sized rig")
    rigs = [fixture_rig() for _ in range(STARTS)]
    ready_s = statistics.median(ready_s for ready_s, _ in rigs)
    report.add(
        "time from file to ready, 4 devices in virtual time", f"{ready_s:.3f} s", "0.3 s", f"{ready_s / 0.3:.2f}"
    )
    report.notes.append(
        f"importing the kernel takes in addition: {statistics.median(import_s for _, import_s in rigs):.2f} s"
    )
    return report


if __name__ == "__main__":
    print(run().markdown())
