"""Each broken node is caught by the cases of the rule that it violates."""

import random

import pytest
from broken_nodes import FAULTS, Fault, Frames
from conform_bench import conformed, numbers
from hypothesis import example, given, settings
from hypothesis import strategies as st

from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.conformance.run import choose
from fieldrig_devices.conformance.suite import Verdict

pytestmark = pytest.mark.long

NEVER_FAILED = {"1.0", "2.30"}
"""Cases for the EDS file and for SDO clients, which this node doesn't have; test_suite covers them."""


@pytest.mark.parametrize("fault", FAULTS)
def test_broken_node_is_caught(fault: str) -> None:
    wanted = FAULTS[fault].cases
    assert numbers(conformed(*wanted, fault=fault), Verdict.FAILED) == [case.number for case in choose(wanted)]


def test_every_case_catches_a_broken_node() -> None:
    """No case passes regardless of the node's behaviour."""
    caught = {number for fault in FAULTS.values() for number in fault.cases}
    assert {case.number for case in choose(())} - caught - NEVER_FAILED == set()


class Garbling(Fault):
    """Loses, truncates, flips and duplicates frames."""

    seed = 0

    def __init__(self) -> None:
        super().__init__()
        self._random = random.Random(self.seed)

    def from_node(self, frame: CanFrame) -> Frames:
        chance, data = self._random, frame.data
        if chance.random() < 0.85:
            yield frame
        elif not frame.is_remote:
            for _ in range(chance.randrange(3)):
                size = chance.choice((len(data), chance.randrange(9)))
                yield CanFrame(frame.identifier, bytes(byte ^ chance.getrandbits(8) for byte in data[:size]))


@settings(max_examples=6, deadline=None)
@example(796)  # an EMCY message of two bytes after a right one
@given(st.integers(0, 1 << 32))
def test_whatever_the_node_sends_every_case_ends_in_a_verdict(seed: int) -> None:
    Garbling.seed = seed
    FAULTS["Garbling"] = Garbling
    try:
        report = conformed("SDO", "PDO 2*", "Emergency", "Guarding", "Testing other", "OD 0[24]", fault="Garbling")
    finally:
        del FAULTS["Garbling"]
    assert len(report.results) == 30 + 10 + 6 + 6 + 10 + 2
