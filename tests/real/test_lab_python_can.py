"""python-can's interfaces as ways into the running lab: socketcand, and slcan on the pty and over TCP."""

from collections.abc import Callable

import can
import pytest
from can.interfaces.slcan import slcanBus
from canopen_network import BusOf
from lab_masters import CanopenMaster, canopen_master, socketcand
from lab_process import LabProcess
from running_rig import until

pytestmark = pytest.mark.real


def slcan_pty(lab: LabProcess) -> BusOf:
    return {"interface": "slcan", "channel": str(lab.slcan_pty), "bitrate": 250_000, "sleep_after_open": 0}


def slcan_tcp(lab: LabProcess) -> BusOf:
    return {"interface": "slcan", "channel": f"socket://127.0.0.1:{lab.slcan_port}", "sleep_after_open": 0}


WAYS: dict[str, Callable[[LabProcess], BusOf]] = {
    "socketcand": socketcand,
    "slcan pty": slcan_pty,
    "slcan tcp": slcan_tcp,
}

NO_NODES: can.typechecking.CanFilters = [
    {"can_id": 0x7F0, "can_mask": 0x7F0, "extended": False},
    {"can_id": 0x1ABCDEF0, "can_mask": 0x1FFFFFF0, "extended": True},
]
"""Only what no node of the lab sends."""


@pytest.fixture(params=WAYS)
def other(request: pytest.FixtureRequest, lab: LabProcess) -> BusOf:
    return WAYS[request.param](lab)


def test_canopen_master_works_by_every_way(lab: LabProcess, other: BusOf) -> None:
    with canopen_master(other) as master:
        master.reset()
        assert master.sensor.sdo[0x1008].raw == "Level sensor"
        master.io.sdo[0x6411][1].raw = 5_000
        until(lambda: lab.get("tank/outlet") == 50)


def test_frames_of_every_format_cross_from_way_to_way(lab: LabProcess, master: CanopenMaster, other: BusOf) -> None:
    messages = [
        can.Message(arbitration_id=0x7F0, data=b"\x01\x02\x03", is_extended_id=False),
        can.Message(arbitration_id=0x7F0, is_extended_id=False),
        can.Message(arbitration_id=0x1ABCDEF0, data=bytes(8)),
    ]
    with can.Bus(**other) as there, can.Bus(**socketcand(lab), can_filters=NO_NODES) as here:
        for message in messages:
            there.send(message)
        heard = [here.recv(10) for _ in messages]
    assert [fields(message) for message in heard] == [fields(message) for message in messages]


def test_remote_frames_cross_between_the_pty_and_tcp(lab: LabProcess) -> None:
    """Not by socketcand: python-can doesn't know its words for them."""
    messages = [
        can.Message(arbitration_id=0x7F1, is_extended_id=False, is_remote_frame=True, dlc=4),
        can.Message(arbitration_id=0x1ABCDEF1, is_remote_frame=True, dlc=0),
    ]
    with can.Bus(**slcan_pty(lab)) as there, can.Bus(**slcan_tcp(lab), can_filters=NO_NODES) as here:
        assert isinstance(here, slcanBus)
        assert here.get_version(10) != (None, None)  # it has heard the command to open, which is not answered
        for message in messages:
            there.send(message)
        heard = [here.recv(10) for _ in messages]
    assert [fields(message) for message in heard] == [fields(message) for message in messages]


def fields(message: can.Message | None) -> tuple[int, bytes, bool, bool, int]:
    assert message is not None
    return (
        message.arbitration_id,
        bytes(message.data),
        message.is_extended_id,
        message.is_remote_frame,
        message.dlc,
    )


def test_no_frame_is_lost_in_a_burst(lab: LabProcess) -> None:
    with can.Bus(**socketcand(lab)) as sender, can.Bus(**socketcand(lab), can_filters=NO_NODES) as receiver:
        for number in range(500):
            sender.send(can.Message(arbitration_id=0x7F5, data=number.to_bytes(2, "big"), is_extended_id=False))
        heard = [receiver.recv(10) for _ in range(500)]
    assert [int.from_bytes(message.data, "big") for message in heard if message is not None] == list(range(500))
