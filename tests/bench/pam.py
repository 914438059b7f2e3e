"""A PAM with 16 axes in 8 pipes of 5 blocks, 4 tasks and 6 Smart-IO nodes, at a basic cycle of 1 ms.

In virtual time all nodes and the ring are in one process, and take turns with the same rig at rest and with a bare ring
of the same nodes.  In real time the ring shows how many cycles it keeps, in each placement: a process for each device,
and one for all nodes.
"""

import json
import sys
import tempfile
from collections.abc import Callable
from concurrent.futures import ProcessPoolExecutor
from functools import partial
from multiprocessing import get_context
from pathlib import Path
from statistics import mean

HERE = Path(__file__).parent
if __name__ == "__main__":
    sys.path[:0] = [str(HERE), str(HERE.parent / "support")]

from pam_machine import DESKS, FIRST_DESK, PIPES, application_text, rig_of  # noqa: E402  in the tests' support
from report import Report, progress  # noqa: E402  found beside this file
from ring import CAN_BE_REALTIME, ROUNDS, SECONDS, measured, rounds  # noqa: E402
from running_rig import RunningRig, until  # noqa: E402
from shipped_rigs import in_turn  # noqa: E402
from turns import shown  # noqa: E402

from fieldrig.clock import S  # noqa: E402
from fieldrig.config.rig_file import from_dict  # noqa: E402
from fieldrig.virtual.rig import Rig  # noqa: E402

RUNS = 3
WINDOWS = 4
"""Simulated seconds of each rig in a run."""
SETTLING_NS = S
LONGEST_START_NS = 20 * S


def at_work(*, optimizes: bool) -> Rig:
    """Return the rig with all axes moving."""
    rig = _booted(application_text(optimizes=optimizes))
    _until(rig, lambda: bool(rig.get("pam", "IFV_Moving")))
    return rig


def at_rest() -> Rig:
    """Return the rig with a running PAM whose programs and pipes wait."""
    rig = _booted(application_text(is_idle=True))
    _until(rig, lambda: rig.get("pam", "state") == "running")
    return rig


def _booted(text: str) -> Rig:
    with tempfile.TemporaryDirectory(prefix="pam") as folder:
        application = Path(folder) / "machine.pam"
        application.write_text(text, encoding="ascii")
        return Rig(from_dict(rig_of(application, "virtual"), HERE))


def _until(rig: Rig, condition: Callable[[], bool]) -> None:
    while not condition():
        rig.run_until(rig.now_ns + SETTLING_NS)
        assert rig.now_ns < LONGEST_START_NS, "the machine does not begin"
    rig.run_until(rig.now_ns + SETTLING_NS)


def bare() -> Rig:
    """Return a ring of as many nodes that do nothing, with the same frames in each cycle."""
    addresses = [*range(1, 2 * PIPES + 1), *range(FIRST_DESK, FIRST_DESK + DESKS)]
    links = {"ring": "ring0"}
    nodes = {
        f"node{address}": {"kind": "pam_devices:Node", "ring_address": address, "links": links} for address in addresses
    }
    master = {"kind": "pam_devices:Master", "addresses": addresses, "groups": PIPES, "links": links}
    buses = {"ring0": {"kind": "pamring.virtual"}}
    rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"master": master, **nodes}}, HERE))
    _until(rig, lambda: bool(rig.get("master", "sent")))
    return rig


BARE = "the bare ring of 22 nodes that do nothing"
RIGS: dict[str, Callable[[], Rig]] = {
    BARE: bare,
    "the PAM, its programs and pipes at rest": at_rest,
    "the PAM at work, sets with OPTIMIZE": partial(at_work, optimizes=True),
    "the PAM at work, frames for each axis": partial(at_work, optimizes=False),
}


def virtual() -> dict[str, float]:
    """Return the simulated seconds in a second of CPU time of each rig, in one whole run from power-on."""
    rigs = {name: make() for name, make in RIGS.items()}
    return {name: mean(speeds) for name, speeds in in_turn(rigs, WINDOWS).items()}


PLACEMENTS: dict[str, dict[str, str]] = {
    "each device in a process of its own": {},
    "all nodes in one process": {"pam": "pam", "nodes": "ring0"},
    "everything in one process": {"all": "*"},
}
"""The key `processes` of the rig file, by the words for it."""


def real(text: str, processes: dict[str, str]) -> str:
    """Return what the rig with this application keeps in real time."""
    with tempfile.TemporaryDirectory(prefix="pam") as folder:
        application = Path(folder) / "machine.pam"
        application.write_text(text, encoding="ascii")
        settings = {"patience_ms": 10_000, "realtime": CAN_BE_REALTIME}
        rig = {**rig_of(application, "real", **settings), "start_timeout_s": 60, "processes": processes}
        with RunningRig(json.dumps(rig), None) as running:  # a rig file may be JSON
            running.until_ready()
            until(lambda: running.value("pam/state") in ("running", "fatal"))
            kept, late, trip, cores, memory = rounds(lambda: measured(running))
            if running.value("pam/state") == "fatal":
                code = running.value("pam/errors")
                return f"the PAM stopped with {code}, as a process was a second behind; {cores}"
    return f"{kept} of the cycles kept, {late} late reports, round trip p50 / p99 {trip}, {cores}, {memory}"


def run() -> Report:
    report = Report(
        "A PAM with 16 axes",
        f"A PAM moves {2 * PIPES} axes by {PIPES} pipes of 5 blocks at a basic cycle of 1 ms. Four tasks calculate,"
        f" change speeds, and drive the outputs of {DESKS} Smart-IO nodes, whose wires lead to the inputs of the next."
        f" In virtual time all is in one process; the rigs take turns: mean and standard deviation of {RUNS} runs from"
        f" power-on, each with {WINDOWS} simulated s of each rig.",
        ("rig", "simulated s per second of CPU time, at least 2", "ratio to the bare ring"),
    )
    runs = []
    for number in range(RUNS):
        progress(f"PAM with 16 axes: run {number + 1}")
        with ProcessPoolExecutor(1, get_context("spawn")) as fresh:  # memory is in order there
            runs.append(fresh.submit(virtual).result())
    for name in RIGS:
        report.add(
            name, shown([run[name] for run in runs], ".2f"), shown([run[name] / run[BARE] for run in runs], ".2f")
        )
    scheduling = "with SCHED_FIFO" if CAN_BE_REALTIME else "without SCHED_FIFO, which needs root"
    slower = application_text().replace("BASIC_PAM_CYCLE = 3;", "BASIC_PAM_CYCLE = 6;")
    texts = {
        "at work": application_text(),
        "at work with a basic cycle of 2 ms": slower,
        "at rest": application_text(is_idle=True),
    }
    for what, text in texts.items():
        for placement, processes in PLACEMENTS.items():
            progress(f"PAM with 16 axes: real time, {what}, {placement}")
            report.notes.append(
                f"in real time {what}, {placement}, over `pamring.shm` {scheduling}, {ROUNDS} rounds of {SECONDS:g} s:"
                f" {real(text, processes)}"
            )
    return report


if __name__ == "__main__":
    print(run().markdown())
