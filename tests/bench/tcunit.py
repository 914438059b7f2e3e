"""TcUnit's own verifier, from the start of Python to the end of the judgement, on the host and in a container.

    TCUNIT=../TcUnit python tests/bench/tcunit.py

The environment variable TCUNIT is a copy of TcUnit's repository, as for `make tcunit`.  The container has the image
`fieldrig`, and is left out if Docker does not answer or does not have it.
"""

import os
import resource
import shutil
import statistics
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE)]

from report import COMPARED, Report, progress  # noqa: E402  found beside this file

FOLDER = Path(os.environ.get("TCUNIT", HERE.parents[2] / "TcUnit"))
VERIFIER = "tcunit_verifier.py"
RUNS = 5
MOST_S = 20
"""The longest that the verifier may take in a container."""
ONCE = "--once"
IMAGE = "fieldrig"


class Took(NamedTuple):
    wall_s: float
    cpu_s: float
    """Processor time of the verifier, with what it starts."""


def verified(folder: Path) -> Took:
    """Run the verifier once in a process of its own; SystemExit if an expectation does not hold."""
    before, began_s = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run([sys.executable, HERE / VERIFIER, folder], capture_output=True, text=True, check=False)
    wall_s, after = time.perf_counter() - began_s, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode:
        raise SystemExit(f"the verifier failed\n{done.stdout}{done.stderr}")
    return Took(wall_s, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime)


def docker(*arguments: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run(["docker", *arguments], capture_output=True, text=True, check=False)


def has_image() -> bool:
    """Return whether Docker answers and has the image."""
    return shutil.which("docker") is not None and docker("image", "inspect", IMAGE).returncode == 0


def in_container(folder: Path) -> Took:
    """Run the verifier once in a container, from its start to its end."""
    mounts = (f"{HERE}:/bench:ro", f"{folder.resolve()}:/tcunit:ro")
    volumes = [word for mount in mounts for word in ("--volume", mount)]
    began_s = time.perf_counter()
    done = docker(
        "run", "--rm", "--network=none", *volumes, "--entrypoint=python", IMAGE, "/bench/tcunit.py", ONCE, "/tcunit"
    )
    wall_s = time.perf_counter() - began_s
    if done.returncode:
        raise SystemExit(f"the container failed\n{done.stdout}{done.stderr}")
    return Took(wall_s, float(done.stdout))


def median(of: Callable[[], Took]) -> Took:
    took = [of() for _ in range(RUNS)]
    return Took(statistics.median(one.wall_s for one in took), statistics.median(one.cpu_s for one in took))


def run() -> Report:
    report = Report(
        "TcUnit's verifier",
        "This table shows how long TcUnit's own verifier takes with its 19 suites that judge behaviour, 215 tests in"
        f" all, from the start of Python on. It is the median of {RUNS} runs, each in a process of its own.",
        COMPARED,
    )
    if not list(FOLDER.rglob("TcUnitVerifier.plcproj")):
        report.notes.append("Left out: TCUNIT=FOLDER, a copy of TcUnit's repository, was not given.")
        return report
    places = {"on the host": verified}
    if has_image():
        places["in a container"] = in_container
    else:
        report.notes.append(f"The container is left out: Docker does not answer, or does not have the image {IMAGE}.")
    for place, of in places.items():
        progress(f"TcUnit's verifier {place}")
        took = median(lambda of=of: of(FOLDER))  # type: ignore[misc]
        report.add(f"verifier {place}", f"{took.wall_s:.1f} s", f"{MOST_S} s", took.wall_s / MOST_S)
        report.add(f"processor time of it {place}", f"{took.cpu_s:.1f} s", f"{MOST_S} s", took.cpu_s / MOST_S)
    return report


if __name__ == "__main__":
    if ONCE in sys.argv:
        print(verified(Path(sys.argv[-1])).cpu_s)
    else:
        print(run().markdown())
