"""`fieldrig up` and `watch` tell what happens to the rig: faults, an open ring, an emergency stop."""

from pathlib import Path

import pytest
from lamp_rig import KINDS as LAMP_KINDS
from lamp_rig import lamp_rig
from running_rig import RunningRig, until

pytestmark = pytest.mark.system

FAULT_KINDS = Path(__file__).with_name("fault_kinds.py")
ALARMS = "{kind: wires.hub, alarms: {lamp.on: {when: true, text: emergency stop}}}"
STOP = lamp_rig().replace("{kind: wires.hub}", ALARMS)
BEACON = """
time: TIME
speed: 1
buses:
  can0: {kind: CAN}
devices:
  io: {kind: "fault_kinds:Beacon", links: {can: can0}}
"""
RING = """
time: virtual
speed: 1
buses:
  ring: {kind: ring.virtual}
devices:
  max4: {kind: max4, drives: {belt: {ring_address: 1}}, links: {ring: ring}}
  belt: {kind: mc4, ring_address: 1, links: {ring: ring}}
"""


def told(rig: RunningRig) -> list[str]:
    """Return the notices of `up` after it was ready, without the times."""
    after = rig.output().partition("ready in")[2]
    return [line.partition("  ")[2] for line in after.splitlines()[1:]]


@pytest.mark.parametrize("kind", ["wires.hub", "wires.zenoh"])
def test_an_emergency_stop_is_told_when_it_begins_and_ends(kind: str) -> None:
    with RunningRig(STOP.replace("wires.hub", kind), LAMP_KINDS) as rig:
        rig.until_ready()
        assert rig.tool("set", "switch/on=true").returncode == 0
        until(lambda: "wires: emergency stop" in told(rig))
        assert rig.tool("set", "switch/on=false").returncode == 0
        until(lambda: "wires: emergency stop: over" in told(rig))
        assert len(told(rig)) == 2


@pytest.mark.parametrize(("time", "can"), [("real", "can.hub"), ("virtual", "can.virtual")])
def test_a_fault_is_told_when_it_begins_and_ends(time: str, can: str) -> None:
    text = BEACON.replace("TIME", time).replace("CAN", can)
    with RunningRig(text if time == "virtual" else text.replace("speed: 1\n", ""), FAULT_KINDS) as rig:
        rig.until_ready()
        assert rig.tool("fault", "can0", "drop", "identifier=0x185").returncode == 0
        assert rig.tool("fault", "io", "mute", "duration_ms=1").returncode == 0
        until(lambda: "io: fault 1: over" in told(rig))
        assert rig.tool("fault", "can0", "--clear", "1").returncode == 0
        until(lambda: "can0: fault 1: over" in told(rig))
        assert sorted(told(rig)) == [
            "can0: fault 1: drop identifier=0x185",
            "can0: fault 1: over",
            "io: fault 1: mute duration_ms=1",
            "io: fault 1: over",
        ]


def test_a_ring_that_opens_is_told() -> None:
    with RunningRig(RING, None) as rig:
        rig.until_ready()
        until(lambda: rig.value("max4/ring.state") == "up")
        assert rig.tool("fault", "ring", "break", "after=max4").returncode == 0
        until(lambda: "ring: the ring is open, without belt" in told(rig))
        assert "ring: fault 1: break after=max4" in told(rig)
        assert rig.tool("fault", "ring", "--clear", "all").returncode == 0
        until(lambda: "ring: the ring is open, without belt: over" in told(rig))
