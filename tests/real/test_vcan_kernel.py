"""The kernel's own CAN under our tests: if these fail, it is not our code that is wrong."""

import shutil
import subprocess

import can
import pytest

pytestmark = [pytest.mark.real, pytest.mark.vcan]


def test_frames_cross_vcan0() -> None:
    with can.Bus("vcan0", "socketcan") as sender, can.Bus("vcan0", "socketcan") as receiver:
        sender.send(can.Message(arbitration_id=0x123, data=b"\x01\x02", is_extended_id=False))
        sender.send(can.Message(arbitration_id=0x1ABCDEF0, is_extended_id=True, is_remote_frame=True, dlc=4))
        data, remote = receiver.recv(5), receiver.recv(5)
    assert data is not None
    assert (data.arbitration_id, bytes(data.data), data.is_extended_id) == (0x123, b"\x01\x02", False)
    assert remote is not None
    assert (remote.arbitration_id, remote.is_remote_frame, remote.dlc) == (0x1ABCDEF0, True, 4)


def test_cansend_is_heard() -> None:
    cansend = shutil.which("cansend")
    assert cansend, "can-utils are not installed"
    with can.Bus("vcan0", "socketcan") as receiver:
        subprocess.run([cansend, "vcan0", "5A1#11.22.33"], check=True)
        heard = receiver.recv(5)
    assert heard is not None
    assert (heard.arbitration_id, bytes(heard.data)) == (0x5A1, bytes.fromhex("11 22 33"))
