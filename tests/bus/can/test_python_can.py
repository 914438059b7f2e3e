"""Interfaces of python-can as buses: an interface without a file descriptor, which is polled."""

from collections.abc import Iterator

import can
import pytest
from direct_bench import DirectBench, direct_bench

from fieldrig.errors import BusError
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.python_can import PythonCan, PythonCanSettings, from_python_can, to_python_can

FRAMES = [
    CanFrame(0x123, b"\x01\x02"),
    CanFrame(0x7FF),
    CanFrame(0x1ABCDEF0, b"\x05", is_extended=True),
    CanFrame(0x18FEF100, is_extended=True, is_remote=True, remote_length=4),
    CanFrame(0x1, bytes(12), is_fd=True, is_bit_rate_switched=True),
]
SETTINGS = PythonCanSettings(interface="virtual", channel="fieldrig")


@pytest.fixture
def bench() -> Iterator[DirectBench]:
    with direct_bench(PythonCan("can0", SETTINGS)) as bench:
        yield bench


@pytest.fixture
def peer() -> Iterator[can.BusABC]:
    with can.Bus(interface="virtual", channel="fieldrig") as peer:
        yield peer


@pytest.mark.parametrize("frame", FRAMES)
def test_frame_is_the_same_there_and_back(frame: CanFrame) -> None:
    assert from_python_can(to_python_can(frame)) == frame


def test_python_can_is_heard_and_hears(bench: DirectBench, peer: can.BusABC) -> None:
    node = bench.join("node")
    heard: list[CanFrame] = []
    node.on_receive(heard.append)
    peer.send(can.Message(arbitration_id=0x123, data=[1, 2], is_extended_id=False))
    peer.send(can.Message(arbitration_id=0x18FEF100, is_remote_frame=True, dlc=4))
    bench.pump(lambda: len(heard) == 2)
    assert heard == [FRAMES[0], FRAMES[3]]
    node.send(FRAMES[2])
    message = peer.recv(5)
    assert message is not None
    assert (message.arbitration_id, bytes(message.data), message.is_extended_id) == (0x1ABCDEF0, b"\x05", True)
    assert bench.at["node"].traced == [("node", FRAMES[2])]


def test_a_message_of_a_driver_that_no_bus_carries_is_dropped(bench: DirectBench, peer: can.BusABC) -> None:
    heard: list[CanFrame] = []
    bench.join("node").on_receive(heard.append)
    peer.send(can.Message(arbitration_id=0x900, is_extended_id=False, check=False))
    peer.send(can.Message(arbitration_id=0x123, data=[1, 2], is_extended_id=False))
    bench.pump(lambda: bool(heard))
    assert heard == [FRAMES[0]]


def test_only_what_is_of_interest_is_heard(bench: DirectBench, peer: can.BusABC) -> None:
    heard: list[CanFrame] = []
    bench.join("node").on_receive(heard.append, [[0x124, 0x7FF | EXTENDED]])
    for identifier in (0x123, 0x124):
        peer.send(can.Message(arbitration_id=identifier, is_extended_id=False))
    bench.pump(lambda: heard == [CanFrame(0x124)])


def test_interface_that_is_not_there_is_named() -> None:
    bus = PythonCan("can0", PythonCanSettings(interface="nonsense", channel="can0"))
    with direct_bench(bus) as bench, pytest.raises(BusError, match="python-can cannot open"):
        bench.join("node")
