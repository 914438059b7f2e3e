"""The bus can.udp, and udp_multicast of python-can."""

import contextlib
import inspect
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import direct_bench as direct_bench_module
import pytest
from can.interfaces.udp_multicast import UdpMulticastBus
from direct_bench import At, check_that_own_frames_come_back, direct_bench
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fieldrig.errors import BusError
from fieldrig.testing import free_port
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.udp import CanUdp, CanUdpSettings, from_wire, to_wire

# Packed by python-can 4.6.1: can.interfaces.udp_multicast.utils.pack_message(Message(timestamp=0.5, ...)).
HEAD = "8b a974696d657374616d70 cb3fe0000000000000 ae6172626974726174696f6e5f6964"
FROM_PYTHON_CAN = {
    "standard": (
        HEAD + "cd0123 ae69735f657874656e6465645f6964 c2 af69735f72656d6f74655f6672616d65 c2"
        "ae69735f6572726f725f6672616d65 c2 a76368616e6e656c c0 a3646c63 02 a464617461 c4020102"
        "a569735f6664 c2 ae626974726174655f737769746368 c2 b56572726f725f73746174655f696e64696361746f72 c2",
        CanFrame(0x123, b"\x01\x02"),
    ),
    "extended remote": (
        HEAD + "ce1abcdef0 ae69735f657874656e6465645f6964 c3 af69735f72656d6f74655f6672616d65 c3"
        "ae69735f6572726f725f6672616d65 c2 a76368616e6e656c c0 a3646c63 04 a464617461 c400"
        "a569735f6664 c2 ae626974726174655f737769746368 c2 b56572726f725f73746174655f696e64696361746f72 c2",
        CanFrame(0x1ABCDEF0, is_extended=True, is_remote=True, remote_length=4),
    ),
    "fd": (
        HEAD + "01 ae69735f657874656e6465645f6964 c2 af69735f72656d6f74655f6672616d65 c2"
        "ae69735f6572726f725f6672616d65 c2 a76368616e6e656c c0 a3646c63 0c a464617461 c40c000102030405060708090a0b"
        "a569735f6664 c3 ae626974726174655f737769746368 c3 b56572726f725f73746174655f696e64696361746f72 c2",
        CanFrame(0x001, bytes(range(12)), is_fd=True, is_bit_rate_switched=True),
    ),
}


@pytest.mark.parametrize(("datagram", "frame"), FROM_PYTHON_CAN.values(), ids=FROM_PYTHON_CAN)
def test_datagrams_are_those_of_python_can(datagram: str, frame: CanFrame) -> None:
    assert from_wire(bytes.fromhex(datagram)) == frame
    assert to_wire(frame, 0.5) == bytes.fromhex(datagram)


def test_error_frames_are_none() -> None:
    datagram, _ = FROM_PYTHON_CAN["standard"]
    assert from_wire(bytes.fromhex(datagram.replace("6f725f6672616d65 c2", "6f725f6672616d65 c3", 1))) is None


@pytest.mark.parametrize(
    ("what", "by"),
    [
        ("cd0123", "cd0800"),  # identifier 0x800 in 11 bits
        ("cd0123", "a3313233"),  # "123"
        ("a3646c63 02", "a3646c63 03"),  # dlc 3 with two bytes
        ("a464617461", "a464617462"),  # a key that is missing
        ("c4020102", "a20102"),  # data as text
        ("8b", "8c"),  # one pair too few
        ("8b", "91"),  # a list, and more behind it
    ],
)
def test_what_is_no_message_is_a_value_error(what: str, by: str) -> None:
    datagram, _ = FROM_PYTHON_CAN["standard"]
    with pytest.raises(ValueError, match=r"."):
        from_wire(bytes.fromhex(datagram.replace(what, by, 1)))


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.binary(max_size=100))
def test_random_bytes_are_a_value_error_or_a_frame(data: bytes) -> None:
    with contextlib.suppress(ValueError):
        from_wire(data)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.sampled_from(sorted(FROM_PYTHON_CAN)), st.integers(0), st.binary(min_size=1, max_size=3))
def test_spoilt_messages_are_a_value_error_or_a_frame(which: str, where: int, what: bytes) -> None:
    datagram = bytearray.fromhex(FROM_PYTHON_CAN[which][0])
    where %= len(datagram)
    datagram[where : where + len(what)] = what
    with contextlib.suppress(ValueError):
        from_wire(bytes(datagram))


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ({"group": "10.0.0.1"}, "expected one such as 239.74.163.2"),
        ({"group": "ff15::1"}, "not an IPv4 multicast address"),
        ({"interface": "eth0"}, "expected one such as 127.0.0.1"),
        ({"interface": "0.0.0.0"}, "is not the address of an interface"),
        ({"port": 0}, "greater than or equal to 1"),
        ({"hop_limit": 256}, "less than or equal to 255"),
    ],
)
def test_settings_that_make_none_are_refused(text: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        CanUdpSettings.model_validate(text)


def test_tools_lead_the_group_to_loopback_first() -> None:
    lines = [tool.line for tool in CanUdp("can0", CanUdpSettings()).tools(Path("run"))]
    assert lines == [
        "sudo ip route add 239.74.163.2/32 dev lo",
        "python -m can.viewer -i udp_multicast -c 239.74.163.2 --bus-kwargs port=43113",
    ]
    elsewhere = CanUdp("can0", CanUdpSettings(interface="192.0.2.1"))
    assert [tool.label for tool in elsewhere.tools(Path("run"))] == ["watch"]


def test_the_defaults_are_python_cans() -> None:
    settings = CanUdpSettings()
    assert settings.group == UdpMulticastBus.DEFAULT_GROUP_IPv4
    assert settings.port == inspect.signature(UdpMulticastBus).parameters["port"].default
    assert CanUdp("can0", settings).python_can() == {
        "interface": "udp_multicast", "channel": "239.74.163.2", "port": 43113, "fd": True,
    }  # fmt: skip


@pytest.mark.system
def test_interface_that_is_not_of_this_machine_is_named() -> None:
    bus = CanUdp("can0", CanUdpSettings(interface="192.0.2.1", port=free_port()))
    with direct_bench(bus) as bench, pytest.raises(BusError, match=r"192\.0\.2\.1") as caught:
        bench.loop.run_until_complete(bus.open(At("node", bench.clock)))
    assert "127.0.0.1" in caught.value.remedy


@pytest.mark.system
def test_each_frame_is_traced_once_by_its_sender() -> None:
    with direct_bench(CanUdp("can0", CanUdpSettings(port=free_port()))) as bench:
        a, b = bench.join("a"), bench.join("b")
        heard: list[CanFrame] = []
        b.on_receive(heard.append)
        a.send(CanFrame(0x123))
        bench.pump(lambda: bool(heard))
        assert bench.at["a"].traced == [("a", CanFrame(0x123))]
        assert bench.at["b"].traced == []


@pytest.mark.system
def test_own_frames_come_back_on_request() -> None:
    with direct_bench(CanUdp("can0", CanUdpSettings(port=free_port()))) as bench:
        check_that_own_frames_come_back(bench)


@pytest.mark.system
def test_bus_without_fd_hears_classical_frames_only() -> None:
    port = free_port()
    with direct_bench(CanUdp("can0", CanUdpSettings(port=port, fd=False))) as bench:
        a, b = bench.join("a"), bench.join("b")
        heard: list[CanFrame] = []
        b.on_receive(heard.append)
        a.send(CanFrame(0x100, is_fd=True))
        a.send(CanFrame(0x200))
        bench.pump(lambda: bool(heard))
        assert heard == [CanFrame(0x200)]


NAMESPACE = ["unshare", "--map-root-user", "--net"]
NETWORK = "ip link set lo up multicast on && ip route add 239.0.0.0/8 dev lo"

PEERS = """
import json, can
from direct_bench import direct_bench
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.udp import CanUdp, CanUdpSettings

bus = CanUdp("can0", CanUdpSettings())
with direct_bench(bus) as bench, can.Bus(**bus.python_can()) as peer:
    node = bench.join("node")
    heard = []
    node.on_receive(heard.append)
    node.send(CanFrame(0x123, b"\\x01\\x02"))
    node.send(CanFrame(0x1ABCDEF0, is_extended=True, is_remote=True, remote_length=4))
    node.send(CanFrame(0x1, bytes(12), is_fd=True, is_bit_rate_switched=True))
    got = [bench.do(peer.recv, 10) for _ in range(3)]
    peer.send(can.Message(arbitration_id=0x456, data=[7, 8], is_extended_id=False))
    peer.send(can.Message(arbitration_id=0x18FEF100, data=bytes(16), is_fd=True))
    bench.pump(lambda: len(heard) == 2)
print(json.dumps({
    "peer": [[m.arbitration_id, m.data.hex(), m.is_extended_id, m.is_remote_frame, m.dlc, m.is_fd, m.bitrate_switch]
             for m in got],
    "node": [bus.show(frame) for frame in heard],
}))
"""


def has_namespaces() -> bool:
    if shutil.which("unshare") is None or shutil.which("ip") is None:
        return False
    return subprocess.run([*NAMESPACE, "true"], capture_output=True, check=False).returncode == 0


@pytest.mark.system
@pytest.mark.skipif(not has_namespaces(), reason="no network namespaces: python-can would join outside")
def test_python_can_sends_and_hears() -> None:
    support = str(Path(direct_bench_module.__file__).parent)
    command = [*NAMESPACE, "sh", "-c", f'{NETWORK} && exec "$0" -c "$1"', sys.executable, PEERS]
    ended = subprocess.run(
        command, env={**os.environ, "PYTHONPATH": support}, capture_output=True, text=True, timeout=60, check=False
    )
    assert ended.returncode == 0, ended.stderr
    assert json.loads(ended.stdout) == {
        "peer": [
            [0x123, "0102", False, False, 2, False, False],
            [0x1ABCDEF0, "", True, True, 4, False, False],
            [0x1, "00" * 12, False, False, 12, True, True],
        ],
        "node": ["456 [2] 07 08", "18FEF100 [16] " + " ".join(["00"] * 16)],
    }
