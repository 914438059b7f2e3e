"""can.socketcan on a real vcan0, with python-can and can-utils at the other end."""

import shutil
import subprocess
from collections.abc import Iterator

import can
import pytest
from direct_bench import DirectBench, check_that_own_frames_come_back, direct_bench

from fieldrig.errors import BusError
from fieldrig_bus.can.acceptance import EXTENDED
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.socketcan import CanSocketcan, CanSocketcanSettings
from fieldrig_bus.can.socketcan_end import MOST_FILTERS, open_socket

pytestmark = [pytest.mark.real, pytest.mark.vcan]

FRAME = CanFrame(0x123, b"\x01\x02")


@pytest.fixture
def bench() -> Iterator[DirectBench]:
    with direct_bench(CanSocketcan("can0", CanSocketcanSettings(channel="vcan0", fd=True))) as bench:
        yield bench


@pytest.fixture
def peer() -> Iterator[can.BusABC]:
    with can.Bus(**CanSocketcan("can0", CanSocketcanSettings(channel="vcan0", fd=True)).python_can()) as peer:  # type: ignore[arg-type]
        yield peer


def received(peer: can.BusABC) -> can.Message:
    message = peer.recv(5)
    assert message is not None
    return message


def test_python_can_hears(bench: DirectBench, peer: can.BusABC) -> None:
    node = bench.join("node")
    node.send(CanFrame(0x123, b"\x01\x02"))
    node.send(CanFrame(0x1ABCDEF0, is_extended=True, is_remote=True, remote_length=4))
    node.send(CanFrame(0x1, bytes(12), is_fd=True, is_bit_rate_switched=True))
    data, remote, fd = received(peer), received(peer), received(peer)
    assert (data.arbitration_id, bytes(data.data), data.is_extended_id) == (0x123, b"\x01\x02", False)
    assert (remote.arbitration_id, remote.is_remote_frame, remote.is_extended_id, remote.dlc) == (
        0x1ABCDEF0, True, True, 4,
    )  # fmt: skip
    assert (fd.arbitration_id, len(fd.data), fd.is_fd, fd.bitrate_switch) == (0x1, 12, True, True)
    assert [sender for sender, _ in bench.at["node"].traced] == ["node"] * 3


def test_python_can_is_heard(bench: DirectBench, peer: can.BusABC) -> None:
    heard: list[CanFrame] = []
    bench.join("node").on_receive(heard.append)
    peer.send(can.Message(arbitration_id=0x123, data=[1, 2], is_extended_id=False))
    peer.send(can.Message(arbitration_id=0x18FEF100, is_remote_frame=True, dlc=3))
    peer.send(can.Message(arbitration_id=0x7FF, data=bytes(64), is_extended_id=False, is_fd=True, bitrate_switch=True))
    bench.pump(lambda: len(heard) == 3)
    assert heard == [
        FRAME,
        CanFrame(0x18FEF100, is_extended=True, is_remote=True, remote_length=3),
        CanFrame(0x7FF, bytes(64), is_fd=True, is_bit_rate_switched=True),
    ]


def test_cansend_is_heard_and_candump_hears(bench: DirectBench) -> None:
    cansend, candump = shutil.which("cansend"), shutil.which("candump")
    assert cansend, "can-utils are not installed"
    assert candump, "can-utils are not installed"
    node = bench.join("node")
    heard: list[CanFrame] = []
    with subprocess.Popen([candump, "-n", "2", "-T", "5000", "vcan0"], stdout=subprocess.PIPE, text=True) as dump:

        def answer(frame: CanFrame) -> None:
            heard.append(frame)
            node.send(CanFrame(0x77))

        def call_until_candump_is_done() -> None:
            while dump.poll() is None:
                subprocess.run([cansend, "vcan0", "5A1#11.22.33"], check=True)

        node.on_receive(answer)
        bench.do(call_until_candump_is_done)
        assert dump.stdout is not None
        lines = [" ".join(line.split()) for line in dump.stdout]
    assert set(heard) == {CanFrame(0x5A1, b"\x11\x22\x33")}
    assert set(lines) == {"vcan0 5A1 [3] 11 22 33", "vcan0 077 [0]"}


def test_the_kernel_keeps_away_what_is_of_no_interest(bench: DirectBench, peer: can.BusABC) -> None:
    heard: list[CanFrame] = []
    node = bench.join("node")
    node.on_receive(heard.append, [[0x123, 0x7FF | EXTENDED]])
    with open_socket("vcan0", fd=False) as bystander:
        for message in (can.Message(arbitration_id=0x124, is_extended_id=False), can.Message(arbitration_id=0x123)):
            peer.send(message)
        with pytest.raises(BlockingIOError):
            bystander.recv(16)
    with pytest.raises(BlockingIOError):
        node.inner.receive()  # type: ignore[attr-defined]  # a SocketcanEnd: its socket has nothing
    peer.send(can.Message(arbitration_id=0x123, data=[1, 2], is_extended_id=False))
    bench.pump(lambda: heard == [FRAME])


def test_more_filters_than_the_kernel_takes_are_applied_here(bench: DirectBench) -> None:
    a, b = bench.join("a"), bench.join("b")
    heard: list[CanFrame] = []
    b.on_receive(heard.append, [[identifier, 0x7FF] for identifier in range(0x100, 0x101 + MOST_FILTERS)])
    for identifier in (0x0FF, 0x100, 0x100 + MOST_FILTERS, 0x101 + MOST_FILTERS, 0x101):
        a.send(CanFrame(identifier))
    bench.pump(lambda: CanFrame(0x101) in heard)
    assert [frame.identifier for frame in heard] == [0x100, 0x100 + MOST_FILTERS, 0x101]


def test_own_frames_come_back_on_request(bench: DirectBench) -> None:
    check_that_own_frames_come_back(bench)


def test_device_that_is_not_there_is_named_with_its_remedy() -> None:
    for channel, remedy in (
        ("vcan7", "sudo ip link add dev vcan7 type vcan && sudo ip link set vcan7 up"),
        ("can7", "sudo ip link set can7 up type can bitrate 500000"),
    ):
        with pytest.raises(BusError, match=f"no CAN network device {channel}") as caught:
            open_socket(channel, fd=False)
        assert remedy in caught.value.remedy


@pytest.fixture
def vcan1() -> Iterator[str]:
    subprocess.run(["ip", "link", "add", "dev", "vcan1", "type", "vcan"], check=True)
    yield "vcan1"
    subprocess.run(["ip", "link", "del", "vcan1"], check=True)


def test_device_that_is_down_is_named(vcan1: str) -> None:
    with pytest.raises(BusError, match="vcan1 is down") as caught:
        open_socket(vcan1, fd=False)
    assert caught.value.remedy == "sudo ip link set vcan1 up"


def test_device_without_fd_is_named_if_fd_is_wanted(vcan1: str) -> None:
    subprocess.run(["ip", "link", "set", vcan1, "mtu", "16"], check=True)
    subprocess.run(["ip", "link", "set", vcan1, "up"], check=True)
    open_socket(vcan1, fd=False).close()
    with pytest.raises(BusError, match="not set up for CAN FD"):
        open_socket(vcan1, fd=True)


def test_device_that_goes_down_and_up_again_carries_on(vcan1: str, caplog: pytest.LogCaptureFixture) -> None:
    subprocess.run(["ip", "link", "set", vcan1, "up"], check=True)
    with direct_bench(CanSocketcan("can0", CanSocketcanSettings(channel=vcan1))) as bench:
        a, b = bench.join("a"), bench.join("b")
        heard: list[CanFrame] = []
        b.on_receive(heard.append)
        subprocess.run(["ip", "link", "set", vcan1, "down"], check=True)
        a.send(CanFrame(0x1))
        bench.pump(lambda: "Network is down" in caplog.text)
        subprocess.run(["ip", "link", "set", vcan1, "up"], check=True)
        a.send(CanFrame(0x2))
        bench.pump(lambda: heard == [CanFrame(0x2)])
