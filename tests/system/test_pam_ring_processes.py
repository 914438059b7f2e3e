"""A PAM's ring between processes: the same frames as in virtual time, and a break while it runs."""

import os
import re
import signal
from collections.abc import Iterator
from pathlib import Path

import pam_node_kinds
import pytest
from running_rig import RunningRig, until

from fieldrig.clock import S
from fieldrig.config.rig_file import load
from fieldrig.virtual.rig import Rig
from fieldrig_bus.ring.transport import shm_carrier

pytestmark = pytest.mark.system

KINDS = Path(pam_node_kinds.__file__)
RIG = """
time: TIME
buses:
  ring0: {kind: pamring.KIND}
devices:
  pam: {kind: "pam_node_kinds:ScriptedPam", links: {ring: ring0}}
  feeder: {kind: "pam_node_kinds:KeepingNode", address: 1, links: {ring: ring0}}
  lift: {kind: "pam_node_kinds:KeepingNode", address: 2, links: {ring: ring0}, process: rack}
  panel: {kind: "pam_node_kinds:KeepingNode", address: 33, is_smart_io: true, links: {ring: ring0}, process: rack}
"""
POINTS = (
    "pam/codes", "pam/sent", "pam/from.1", "pam/from.2", "pam/from.33", "feeder/heard", "lift/heard", "panel/heard",
)  # fmt: skip


CARRIERS = [*(["shm"] if shm_carrier.is_available() else []), "zenoh"]


@pytest.fixture(params=CARRIERS)
def ring(request: pytest.FixtureRequest) -> Iterator[RunningRig]:
    environment = {"PYTHONPATH": str(KINDS.parent)}
    rig = RIG.replace("TIME", "real").replace("KIND", request.param)
    with RunningRig(rig, KINDS, environment=environment) as running:
        running.until_ready()
        until(lambda: running.value("pam/step") == pam_node_kinds.STEPS or running.value("pam/phase") == "FAILED")
        yield running


def in_virtual_time(folder: Path) -> dict[str, str]:
    """The points after the whole script in virtual time."""
    (folder / KINDS.name).symlink_to(KINDS)
    file = folder / "ring.yaml"
    file.write_text(RIG.replace("TIME", "virtual").replace("KIND", "virtual"))
    with Rig(load(file)) as rig:
        rig.run_until(S)
        return {point: str(rig.get(*point.split("/"))) for point in POINTS}


def test_processes_exchange_the_same_frames_as_in_virtual_time(ring: RunningRig, tmp_path: Path) -> None:
    expected = in_virtual_time(tmp_path)
    assert len(expected["pam/sent"].splitlines()) > 2 * pam_node_kinds.STEPS
    assert len(expected["feeder/heard"].splitlines()) > pam_node_kinds.STEPS
    until(lambda: ring.value("pam/from.33") == expected["pam/from.33"])
    assert {point: ring.value(point) for point in POINTS} == expected


@pytest.mark.parametrize("ring", CARRIERS[:1], indirect=True)
@pytest.mark.manual("PAMS-106", "PAMS-108")
def test_a_break_stops_the_ring_and_the_node_behind_it_shows_it(ring: RunningRig) -> None:
    ring.json("fault", "ring0", "break", "after=feeder")
    until(lambda: ring.value("pam/phase") == "FAILED")
    assert str(ring.value("pam/codes")).endswith("06..F010 07..E013")
    until(lambda: ring.value("feeder/fault") == "INACTIVE")
    assert (ring.value("lift/fault"), ring.value("panel/fault")) == ("CARRIER", "INACTIVE")


@pytest.mark.skipif(not hasattr(signal, "SIGSTOP"), reason="stops a process")
@pytest.mark.parametrize("ring", CARRIERS[:1], indirect=True)
def test_a_ring_that_fails_because_the_host_lets_a_process_stand_still_says_so(ring: RunningRig) -> None:
    rack = ring.pid("rack")
    os.kill(rack, signal.SIGSTOP)
    try:
        until(lambda: ring.value("pam/phase") == "FAILED")
    finally:
        os.kill(rack, signal.SIGCONT)
    log = ring.log("pam")
    assert re.search(
        r"the ring has failed: \S+ \(the host was up to [0-9,]+ ms late in the last seconds, load ", log
    ), log
    until(lambda: "warning: the host is late: " in ring.output())
