"""All benchmarks, one after another: `make bench` writes docs/developers/benchmarks.md."""

import os
import platform
import subprocess
import sys
from collections.abc import Sequence
from datetime import date
from importlib.metadata import version
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

import arp_language  # noqa: E402  found beside this file
import arp_loop  # noqa: E402
import block_status  # noqa: E402
import branches  # noqa: E402
import can_hub  # noqa: E402
import canopen_node  # noqa: E402
import coverage_cost  # noqa: E402
import drive_cycle  # noqa: E402
import flood  # noqa: E402
import iec_language  # noqa: E402
import master_time  # noqa: E402
import modbus  # noqa: E402
import page_ready  # noqa: E402
import page_ring  # noqa: E402
import page_scope  # noqa: E402
import pam  # noqa: E402
import pam_language  # noqa: E402
import pam_pipes  # noqa: E402
import planted_bugs  # noqa: E402
import plc_on_ring  # noqa: E402
import program_tests  # noqa: E402
import pulse_engine  # noqa: E402
import pulses  # noqa: E402
import recording  # noqa: E402
import replay  # noqa: E402
import ring  # noqa: E402
import ring_network  # noqa: E402
import search  # noqa: E402
import search_farm  # noqa: E402
import shipped_rigs  # noqa: E402
import single_drive  # noqa: E402
import start_up  # noqa: E402
import tcunit  # noqa: E402
import teleservice  # noqa: E402
import timers  # noqa: E402
import trace_codecs  # noqa: E402
import trace_formats  # noqa: E402
import trace_names  # noqa: E402
import virtual_time  # noqa: E402

BENCHMARKS = (
    start_up,
    timers,
    can_hub,
    canopen_node,
    modbus,
    ring,
    ring_network,
    flood,
    recording,
    trace_names,
    trace_formats,
    trace_codecs,
    replay,
    pulses,
    search_farm,
    shipped_rigs,
    drive_cycle,
    single_drive,
    virtual_time,
    branches,
    search,
    program_tests,
    tcunit,
    coverage_cost,
    planted_bugs,
    master_time,
    arp_language,
    arp_loop,
    iec_language,
    pam,
    pam_language,
    pam_pipes,
    plc_on_ring,
    pulse_engine,
    teleservice,
    block_status,
    page_ready,
    page_ring,
    page_scope,
)
PEERS = ("python-can", "canopen", "pymodbus", "eclipse-zenoh", "uvloop")
PAGE = HERE.parents[1] / "docs/developers/benchmarks.md"

INTRODUCTION = """# Benchmarks

Written by `make bench`; don't edit.  Ratios are within one run, against a named peer or the line's own limit; seconds
depend on the machine.  `python tests/bench NAME...` measures single tables again, so each table names its commit.
"""
MEASURED = (
    "Measured {day} on commit {commit}, {cores} cores with a load average of {load:.0f} over 5 minutes{before_others},"
    " {system}, Python {python}, {peers}.\n"
)


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


def measured() -> str:
    """Return the sentence under a table that says when, on which commit and on what it was measured."""
    return MEASURED.format(
        commit=commit(),
        day=date.today().isoformat(),  # noqa: DTZ011  the day where the reader is
        cores=os.cpu_count(),
        load=os.getloadavg()[1],
        before_others=f" at a niceness of {niceness}" if (niceness := os.nice(0)) else "",
        system=f"{platform.system()} {platform.machine()}",
        python=platform.python_version(),
        peers=", ".join(f"{name} {version(name)}" for name in PEERS),
    )


def tables_of(page: str) -> dict[str, str]:
    """Return the tables of the page by their titles, each with its title."""
    parts = page.split("\n## ")[1:]
    return {part.split("\n", 1)[0]: f"## {part.strip()}\n" for part in parts}


def main(names: Sequence[str]) -> None:
    """Measure the benchmarks of these names, or all if there are none, and write their tables into the page."""
    known = {benchmark.__name__: benchmark for benchmark in BENCHMARKS}
    if unknown := sorted(set(names) - set(known)):
        raise SystemExit(f"no benchmark {', '.join(unknown)}: expected some of {', '.join(known)}")
    tables = tables_of(PAGE.read_text()) if names else {}
    for name in names or known:
        report = known[name].run()
        tables[report.title] = f"{report.markdown()}\n{measured()}"
        if names:
            PAGE.write_text("\n".join([INTRODUCTION, *tables.values()]))  # a later one may fail
    PAGE.write_text("\n".join([INTRODUCTION, *tables.values()]))
    print(f"written to {PAGE}")


if __name__ == "__main__":
    main(sys.argv[1:])
