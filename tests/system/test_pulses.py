"""Pulses between processes in real time: if one of them is killed, the account of sent and counted pulses closes."""

import os
import signal
from collections.abc import Iterator

import pytest
from running_rig import AskedRig, until

pytestmark = pytest.mark.system

RIG = """
time: real
buses:
  wires: {kind: KIND}
devices:
  source: {kind: pulse.generator, frequency: 20000, links: {wires: wires}}
  counter: {kind: pulse.counter, a_wire: source.pulse, links: {wires: wires}}
  axis: {kind: plant.pulse-servo, pulse_wire: source.pulse, links: {wires: wires}}
  card: {kind: arp, number: 1, links: {wires: wires}, signals: {encoder1: source.pulse}}
"""


@pytest.fixture(params=["wires.hub", "wires.zenoh"])
def rig(request: pytest.FixtureRequest) -> Iterator[AskedRig]:
    with AskedRig(RIG.replace("KIND", request.param), None) as rig:
        rig.until_ready()
        yield rig


def kill(rig: AskedRig, process: str) -> None:
    os.kill(rig.pid(process), signal.SIGKILL)
    rig.until_back(process)


def test_every_receiver_has_counted_what_was_sent(rig: AskedRig) -> None:
    for count, direction in ((5_000, 1), (2_000, -1)):
        rig.set("source/count", count)
        rig.set("source/direction", direction)
        rig.set("source/run", True)
        until(lambda: rig.get("source/run") is False)
    assert rig.get("source/sent") == 7_000
    until(lambda: rig.get("counter/value") == 3_000)
    until(lambda: rig.get("card/encoder1") == 3_000)
    until(lambda: rig.get("axis/in_position") is True)
    assert (rig.get("axis/received"), rig.get("axis/missed")) == (7_000, 0)


def test_a_counter_that_was_killed_shows_what_it_missed(rig: AskedRig) -> None:
    rig.set("source/run", True)
    kill(rig, "counter")
    rig.set("source/run", False)
    sent = rig.get("source/sent")
    until(lambda: rig.get("counter/value") + rig.get("counter/missed") - rig.get("counter/surplus") == sent)
    assert rig.get("counter/missed") > 0
    until(lambda: rig.get("axis/received") == sent)
    assert rig.get("axis/missed") == 0


def test_a_sender_that_was_killed_and_starts_again_is_noticed(rig: AskedRig) -> None:
    rig.set("source/run", True)
    until(lambda: rig.get("counter/value") > 0)
    kill(rig, "source")
    until(lambda: rig.get("counter/restarts") == 1)
    before = rig.get("counter/value")
    rig.set("source/count", 1_000)
    rig.set("source/run", True)
    until(lambda: rig.get("counter/value") == before + 1_000)
    assert rig.get("counter/missed") == 0


@pytest.mark.parametrize("rig", ["wires.hub"], indirect=True)
def test_a_hub_that_was_killed_costs_no_pulse_without_notice(rig: AskedRig) -> None:
    rig.set("source/run", True)
    os.kill(rig.pid("wires"), signal.SIGKILL)
    rig.set("source/frequency", 5_000)
    rig.set("source/run", True)  # a segment that may reach no hub
    rig.until_back("wires")
    rig.set("source/run", False)
    sent = rig.get("source/sent")
    until(lambda: rig.get("counter/value") + rig.get("counter/missed") - rig.get("counter/surplus") == sent)
    until(lambda: rig.get("axis/sent") == sent)
