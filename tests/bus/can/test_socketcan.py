"""Bytes exchanged with the kernel, as in include/uapi/linux/can.h.  tests/real has a real vcan0."""

import asyncio
import socket
import sys
from pathlib import Path

import pytest
from direct_bench import At
from hub_bench import LoopBench
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.errors import BusError
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.socketcan import CanSocketcan, CanSocketcanSettings
from fieldrig_bus.can.socketcan_wire import from_wire, kernel_filters, to_wire

pytestmark = pytest.mark.skipif(sys.byteorder != "little", reason="the bytes are a little-endian machine's")

# struct can_frame: can_id 4, len 1, pad 3, data 8; canfd_frame: can_id 4, len 1, flags 1, res 2, data 64
WIRE = [
    (CanFrame(0x123, b"\x11\x22"), "23010000 02000000 1122000000000000"),
    (CanFrame(0x7FF, bytes(range(8))), "ff070000 08000000 0001020304050607"),
    (CanFrame(0x1ABCDEF0, is_extended=True), "f0debc9a 00000000 0000000000000000"),
    (CanFrame(0x123, is_remote=True, remote_length=4), "23010040 04000000 0000000000000000"),
    (CanFrame(0x1, b"", True, True, 8), "010000c0 08000000 0000000000000000"),
    (CanFrame(0x123, b"\x01", is_fd=True), "23010000 01000000 01" + "00" * 63),
    (CanFrame(0x123, bytes(64), False, False, 0, True, True), "23010000 40010000" + "00" * 64),
    (CanFrame(0x1, b"\xff" * 12, is_extended=True, is_fd=True), "01000080 0c000000" + "ff" * 12 + "00" * 52),
]


@pytest.mark.parametrize(("frame", "data"), WIRE)
def test_frames_are_the_kernels_structs(frame: CanFrame, data: str) -> None:
    assert to_wire(frame) == bytes.fromhex(data)
    assert from_wire(bytes.fromhex(data)) == frame


def test_the_kernels_mark_of_an_fd_frame_says_nothing_new() -> None:
    assert from_wire(bytes.fromhex("23010000 00050000") + bytes(64)) == CanFrame(
        0x123, b"", False, False, 0, True, True
    )


def test_error_frames_are_none() -> None:
    assert from_wire(bytes.fromhex("04000020 08000000 0001000000000000")) is None


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.binary(min_size=16, max_size=16) | st.binary(min_size=72, max_size=72))
def test_any_bytes_of_the_kernel_are_a_frame_that_a_bus_can_carry(data: bytes) -> None:
    frame = from_wire(data)
    assert frame is None or from_wire(to_wire(frame)) == frame


# struct can_frame and canfd_frame (can.h) as a program on a vcan may fill them, and what a controller would send.
ODD = [
    ("00080000 02000000 0102000000000000", CanFrame(0, b"\x01\x02")),  # 800h without CAN_EFF_FLAG: its 11 bits
    ("01020040 0f000000 0000000000000000", CanFrame(0x201, is_remote=True, remote_length=8)),  # DLC 15 means 8
    (
        "23010000 0a010000" + "ff" * 10 + "00" * 54,
        CanFrame(0x123, b"\xff" * 10 + bytes(2), False, False, 0, True, True),
    ),
    ("23010040 02000000" + "ff" * 2 + "00" * 62, CanFrame(0x123, b"\xff\xff", is_fd=True)),  # FD has no remote frames
]


@pytest.mark.parametrize(("data", "frame"), ODD)
def test_what_no_controller_can_send_becomes_what_it_would_send(data: str, frame: CanFrame) -> None:
    assert from_wire(bytes.fromhex(data)) == frame


def test_interest_becomes_the_kernels_filters() -> None:
    assert kernel_filters(()) == b""
    assert kernel_filters(None) == bytes(8)
    assert kernel_filters(((0x181, 0x7FF), (0x181 | EXTENDED, 0xFFFFFFFF))) == bytes.fromhex(
        "81010000 ff070000 81010080 ffffffdf"
    )
    assert kernel_filters(((0x20000001, 0x3FFFFFFF),)) == b""  # no frame can match: bit 29 is never set


def opened(channel: str) -> None:
    bench = LoopBench()
    bus = CanSocketcan("can0", CanSocketcanSettings(channel=channel))

    async def open_and_close() -> None:
        await bus.open(At("node", bench.clock))
        await bus.close("node")

    try:
        bench.loop.run_until_complete(open_and_close())
    finally:
        bench.close()


@pytest.mark.system
def test_what_is_not_there_is_named_with_its_remedy() -> None:
    with pytest.raises(BusError) as caught:
        opened("nowhere0")
    assert "sudo ip link set nowhere0 up" in caught.value.remedy or "modprobe can-raw" in caught.value.remedy


def test_the_error_without_socketcan_names_can_hub(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delattr(socket, "AF_CAN", raising=False)
    with pytest.raises(BusError, match="no SocketCAN") as caught:
        opened("vcan0")
    assert "can.hub" in caught.value.remedy


@pytest.mark.parametrize("text", [{}, {"channel": ""}, {"channel": "a" * 16}, {"channel": "can 0"}, {"channel": "a/b"}])
def test_channel_that_is_no_network_device_is_refused(text: dict[str, str]) -> None:
    with pytest.raises(ValidationError, match="channel"):
        CanSocketcanSettings.model_validate(text)


def test_tools_and_python_can_reach_it() -> None:
    bus = CanSocketcan("can0", CanSocketcanSettings(channel="vcan0"))
    assert [tool.line for tool in bus.tools(Path("run"))] == [
        "candump vcan0",
        "cansend vcan0 123#1122",
        "python -m can.viewer -i socketcan -c vcan0",
    ]
    assert bus.python_can() == {"interface": "socketcan", "channel": "vcan0", "fd": False}


def test_closing_what_was_never_opened_does_no_harm() -> None:
    asyncio.run(CanSocketcan("can0", CanSocketcanSettings(channel="vcan0")).close("node"))
