"""The rigs of configs/ring.yaml and packaging-line.yaml: what is in them, and that they come up in real time."""

import os
import signal

import pytest
from ring_process import CONFIGS, RingProcess
from running_rig import RunningRig, until

from fieldrig.config.rig_file import load
from fieldrig.real.live_rig import UpProcess

pytestmark = [pytest.mark.system, pytest.mark.timeout(400)]

WARNING = (
    "warning: ring has a cycle of 1 ms and 5 processes: to wake them takes 0.6 cores or more, and this host has 1,"
    " so cycles may be lost"
)
OTHERS = ("lab.yaml", "arp-cell.yaml", "machine.yaml")


def test_rigs_may_run_beside_each_other() -> None:
    """No port is in two of them."""
    places: list[str] = []
    for name in ("ring.yaml", "packaging-line.yaml", *OTHERS):
        lines = (CONFIGS / name).read_text(encoding="utf-8").splitlines()
        keys = ("control: tcp/", "socketcand:", "listen:")
        places += [line.split("127.0.0.1:")[1].split()[0] for line in lines if line.strip().startswith(keys)]
    assert len(places) == len(set(places)) > 8


def test_drives_of_the_ring_have_processes_of_their_own_and_those_of_the_line_racks() -> None:
    ring, line = load(CONFIGS / "ring.yaml"), load(CONFIGS / "packaging-line.yaml")
    assert [device.process for device in ring.devices.values() if device.kind == "mc4"] == [
        "infeed",
        "film",
        "jaw",
        "outfeed",
    ]
    racks = [device.process for device in line.devices.values() if device.kind == "mc4"]
    assert racks == [f"rack{number}" for number in (1, 2, 3, 4) for _ in range(10)]


def test_the_line_of_forty_comes_up_and_an_axis_of_each_rack_is_enabled() -> None:
    with RingProcess("packaging-line.yaml") as line:
        line.until_ready().until_up()
        assert line.get("max4/DiagCode") == 0
        axes = ("in1", "jaw2", "press", "stretch")
        for name in axes:
            line.set(f"max4/{name}.ControllerEnable", True)
        until(lambda: all(line.get(f"max4/{name}.AxisState") == 3 for name in axes))
        assert line.end(signal.SIGINT) == 0, line.output()


class RigProgram(RunningRig):
    """A rig that is no fork of another process, so that it inherits what this one has."""

    start_up = UpProcess.start_up


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="sets the cores of a process")
def test_up_warns_before_the_start_of_a_ring_with_too_many_processes_for_the_cores() -> None:
    cores = os.sched_getaffinity(0)
    os.sched_setaffinity(0, {min(cores)})  # the rig inherits it
    try:
        rig = RigProgram(CONFIGS / "ring.yaml", None, "--set=devices.max4.cycle_ms=1")
    finally:
        os.sched_setaffinity(0, cores)
    with rig:
        until(lambda: "control at" in rig.output() or rig.process.poll() is not None)
        assert rig.output().splitlines()[:2] == [
            WARNING,
            "    this line in the rig file helps: processes: {max4: max4, ring: ring}",
        ]
        rig.end()
