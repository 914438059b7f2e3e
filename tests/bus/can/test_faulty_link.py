"""Fault injection at a device's own end of a CAN bus whose medium exists outside the rig."""

from collections.abc import Mapping
from pathlib import Path
from random import Random
from typing import Any

import pytest
from pydantic import TypeAdapter, ValidationError

from fieldrig.clock import MS, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.can.faulty_link import FaultyLink, LinkFault
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.notices import FaultNote
from fieldrig_bus.can.udp import CanUdpSettings

ONE, TWO = CanFrame(1, b"\x01"), CanFrame(2)


class Bench:
    """An attachment, and its link."""

    member, process, rig, seed = "io", "io", "lab", 7
    members: Mapping[str, str] = {"io": "io"}

    def __init__(self, *faults: dict[str, Any]) -> None:
        self.clock, self.medium = VirtualClock(), RecordedLink[CanFrame]()
        self.heard_by_trace: list[Any] = []
        given = [TypeAdapter[LinkFault](LinkFault).validate_python(fault) for fault in faults]
        self.link = FaultyLink(self, self.medium, given, Random("7/can0/io"))

    def path(self, name: str) -> Path:
        raise NotImplementedError

    def serve(self, subject: Any) -> None:
        raise NotImplementedError

    def note_late(self, late_ns: int) -> None:
        raise NotImplementedError

    def session(self) -> Any:
        raise NotImplementedError

    def deliver(self, handler: Any, message: Any, instant_ns: int | None = None) -> None:
        handler(message)

    def heard(self, sender: str, message: Any) -> None:
        self.heard_by_trace.append(message)


def test_a_frame_is_dropped_on_its_way_out_and_the_trace_says_so() -> None:
    bench = Bench({"what": "drop", "identifier": 1, "count": 1})
    for frame in (ONE, TWO, ONE):
        bench.link.send(frame)
    assert bench.medium.sent == [TWO, ONE]
    assert bench.heard_by_trace == [FaultNote(1, "dropped")]


def test_a_frame_of_another_node_is_left_alone() -> None:
    bench = Bench({"what": "drop", "node": "master"})
    bench.link.send(ONE)
    assert bench.medium.sent == [ONE]


def test_a_frame_is_dropped_on_its_way_in() -> None:
    bench = Bench({"what": "drop", "identifier": 1, "receivers": ["io"]})
    heard: list[CanFrame] = []
    bench.link.on_receive(heard.append, [[1, 0x7FF]])
    assert bench.medium.interest == [[1, 0x7FF]]
    bench.medium.deliver(ONE)
    bench.medium.deliver(TWO)
    bench.link.send(ONE)
    assert heard == [TWO]
    assert bench.medium.sent == [ONE]
    assert bench.heard_by_trace == [FaultNote(1, "dropped for io")]


def test_a_delayed_frame_keeps_those_behind_it_back() -> None:
    bench = Bench({"what": "delay", "identifier": 1, "delay_ms": 2})
    bench.link.send(ONE)
    bench.link.send(TWO)
    bench.clock.advance_to(2 * MS - 1)
    assert bench.medium.sent == []
    bench.clock.advance_to(2 * MS)
    assert bench.medium.sent == [ONE, TWO]


def test_a_frame_is_doubled_and_its_data_changed() -> None:
    bench = Bench({"what": "duplicate"}, {"what": "replace", "xor": "ff"})
    bench.link.send(ONE)
    assert bench.medium.sent == [CanFrame(1, b"\xfe")] * 2


def test_a_fault_of_bits_is_refused_where_bits_are_out_of_reach() -> None:
    with pytest.raises(ValidationError, match="'drop', 'delay', 'duplicate', 'replace'"):
        CanUdpSettings.model_validate({"faults": [{"what": "short"}]})


def test_a_link_takes_faults_while_it_runs_under_numbers_that_are_given() -> None:
    bench = Bench({"what": "drop", "identifier": 2})
    bench.link.injected.add_fault({"what": "replace", "data": "77", "identifier": "0x1"}, 5)
    assert bench.link.injected.given == 5
    bench.link.send(ONE)
    assert bench.medium.sent == [CanFrame(1, b"\x77")]
    assert bench.link.injected.faults()[5] == {
        "what": "replace",
        "data": "77",
        "identifier": 1,
        "state": "on",
        "applied": 1,
    }
    bench.link.injected.clear_fault(5)
    bench.link.send(ONE)
    assert bench.medium.sent[1:] == [ONE]
    assert list(bench.link.injected.faults()) == [1]
    with pytest.raises(ValueError, match="there is no fault 'corrupt'\nthere are: drop, delay, duplicate, replace"):
        bench.link.injected.add_fault({"what": "corrupt"}, 6)
    with pytest.raises(ValueError, match="there is no fault 5"):
        bench.link.injected.clear_fault(5)
