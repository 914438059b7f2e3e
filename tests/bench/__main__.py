"""All benchmarks, one after another: `make bench` writes docs/benchmarks.md."""

import os
import platform
import subprocess
import sys
from datetime import date
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

import arp_language  # noqa: E402  found beside this file
import arp_loop  # noqa: E402
import can_hub  # noqa: E402
import canopen_node  # noqa: E402
import drive_cycle  # noqa: E402
import modbus  # noqa: E402
import ring  # noqa: E402
import shipped_rigs  # noqa: E402
import start_up  # noqa: E402
import timers  # noqa: E402
import virtual_time  # noqa: E402

BENCHMARKS = (
    start_up,
    timers,
    can_hub,
    canopen_node,
    modbus,
    ring,
    shipped_rigs,
    drive_cycle,
    virtual_time,
    arp_language,
    arp_loop,
)
PEERS = ("python-can", "canopen", "pymodbus", "eclipse-zenoh", "uvloop")
PAGE = HERE.parents[1] / "docs/benchmarks.md"

INTRODUCTION = """# Benchmarks

This page shows what fieldrig can carry on {cores} cores, and how it compares with other programs. `make bench` measures
the figures and writes the page, so do not edit it. A ratio compares two figures of the same run: with a named program,
or with the limit of the line. Figures in seconds depend on the host.

Measured {day} on commit {commit}, {system}, Python {python}, {peers}.
"""


def commit() -> str:
    """The measured commit, marked as changed if the files differ from it."""
    described = subprocess.run(
        ["git", "describe", "--always", "--dirty=, changed since"],
        cwd=HERE,
        capture_output=True,
        text=True,
        check=False,
    )
    return described.stdout.strip() or "unknown"


def main() -> None:
    introduction = INTRODUCTION.format(
        commit=commit(),
        day=date.today().isoformat(),  # noqa: DTZ011  the day where the reader is
        cores=os.cpu_count(),
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        peers=", ".join(f"{name} {version(name)}" for name in PEERS),
    )
    reports = [benchmark.run().markdown() for benchmark in BENCHMARKS]
    PAGE.write_text("\n".join([introduction, *reports]))
    print(f"written to {PAGE}")


if __name__ == "__main__":
    main()
