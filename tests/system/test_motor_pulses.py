"""A DC motor and its Smart-IO in processes of their own: a node that stands still for a while has all of its pulses."""

import os
import signal
from math import floor

import pytest
from running_rig import AskedRig, until

pytestmark = pytest.mark.system

RIG = """
time: real
buses:
  wires: {kind: wires.hub, process: hub}
devices:
  io:
    kind: smart_io
    process: node
    links: {wires: wires}
    modules: {1: {period_ms: 1, debounce: 1}, 2: {}}
    terminals: {in101: rail.pulse, in102: rail.zero, out201: rail.increase, out202: rail.decrease}
    motors: [{increase: 201, decrease: 202, zero: 102, counter: 101, timeout_ms: 60000}]
  rail:
    kind: plant.dc-motor
    process: plant
    links: {wires: wires}
    increase_wire: rail.increase
    decrease_wire: rail.decrease
    output: segments
    initial_position: 0.25
"""
RUN, STOP, FORWARDS = 3, 4, 1


def test_a_node_that_stands_still_has_all_pulses_afterwards() -> None:
    with AskedRig(RIG, None) as rig:
        rig.until_ready()
        rig.set("io/motor1.value", FORWARDS)
        rig.set("io/motor1.order", RUN)
        until(lambda: float(rig.get("rail/position")) > 10)
        node = rig.pid("node")
        os.kill(node, signal.SIGSTOP)
        try:
            until(lambda: float(rig.get("rail/position")) > 30)
        finally:
            os.kill(node, signal.SIGCONT)
        rig.set("io/motor1.order", STOP)
        until(lambda: rig.get("rail/speed") == 0 and rig.get("io/motor1.ready") is True)
        assert rig.get("io/motor1.position") == floor(float(rig.get("rail/position")))
