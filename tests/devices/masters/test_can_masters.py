"""CAN masters of foreign libraries, unchanged, in virtual time."""

import asyncio
import hashlib
import threading
import time
from typing import Any

import can
import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from doc_pages import ROOT, blocks

from fieldrig import Bus, Delivery, Rig, S, from_dict, virtual_time
from fieldrig.pytest_plugin import MasterRigMaker
from fieldrig_devices.max4 import EDS

pytestmark = pytest.mark.timeout(120)
PAGE = ROOT / "docs" / "cia402.md"
AXES: dict[str, Any] = {
    "time": "virtual",
    "buses": {"can0": {"kind": "can.virtual", "bitrate": 1_000_000, "socketcand": "127.0.0.1:29536"}},
    "devices": {
        "max4": {
            "kind": "max4",
            "links": {"can": "can0"},
            "drives": {"belt": {"ring_address": 1, "simulated": True}},
            "inputs": {"I_bHomeBelt": ""},
            "can_axes": {"node_ids": [10], "terminals": {"belt": {"home": "I_bHomeBelt"}}},
        }
    },
}
FIELDRIG: dict[str, Any] = {"interface": "fieldrig", "channel": "can0"}
SOCKETCAND: dict[str, Any] = {"interface": "socketcand", "channel": "can0", "host": "127.0.0.1", "port": 29536}


class Heard:
    """A hash of everything that was on the buses, with the instants."""

    def __init__(self) -> None:
        self.hash, self.count = hashlib.sha256(), 0

    def __call__(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.hash.update(f"{delivery.time_ns} {delivery.sender} ".encode() + bus.encode(delivery.message))
        self.count += 1


class Axis(BaseNode402):
    TIMEOUT_SWITCH_STATE_SINGLE = 1
    TIMEOUT_SWITCH_STATE_FINAL = TIMEOUT_SWITCH_OP_MODE = TIMEOUT_CHECK_TPDO = 20


AXIS: Any = Axis


def home(rig: Rig, where: dict[str, Any], sync_s: float | None = None) -> bool:
    """Home the belt by method 19, whose switch closes after a minute; return whether it was reached."""
    network: Any = canopen.Network()
    network.connect(**where)
    belt: Any = AXIS(10, str(EDS))
    network.add_node(belt)
    belt.nmt.state = "PRE-OPERATIONAL"
    belt.tpdo[2].read()
    belt.rpdo[1].read()
    belt.rpdo[1].clear()
    for index in (0x6040, 0x6060):
        belt.rpdo[1].add_variable(index)
    belt.rpdo[1].save()
    belt.setup_402_state_machine(read_pdos=False)
    belt.nmt.state = "OPERATIONAL"
    if sync_s is not None:
        network.sync.start(sync_s)
    belt.op_mode = "HOMING"
    belt.sdo[0x6098].raw = 19
    belt.sdo[0x6099][1].raw = 100_000
    belt.sdo[0x6099][2].raw = 10_000

    def switch() -> None:
        time.sleep(57)
        rig.set("max4", "I_bHomeBelt.Value", True)
        time.sleep(3)
        rig.set("max4", "I_bHomeBelt.Value", False)

    switching = threading.Thread(target=switch)
    switching.start()
    is_homed = bool(belt.homing(timeout=120))
    switching.join()
    if sync_s is not None:
        network.sync.stop()
    network.disconnect()
    return is_homed


def homed(where: dict[str, Any], sync_s: float | None = None, **options: Any) -> tuple[bool, int, int, str]:
    heard = Heard()
    with Rig(from_dict(AXES), heard) as rig:
        with virtual_time(rig, **options):
            is_homed = home(rig, where, sync_s)
        return is_homed, rig.now_ns, heard.count, heard.hash.hexdigest()


@pytest.mark.long
def test_the_program_of_the_page_moves_an_axis_verbatim(
    fieldrig_master: MasterRigMaker, capsys: pytest.CaptureFixture[str]
) -> None:
    program = next(block.text for block in blocks(PAGE) if "can_belt.py" in block.info)
    rig = fieldrig_master(AXES)
    exec(compile(program, "can_belt.py", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out == "belt has moved by 1000000\n"
    assert isinstance(rig, Rig)
    assert 1 * S < rig.now_ns < 3 * S


@pytest.mark.long
@pytest.mark.parametrize("where", [FIELDRIG, SOCKETCAND], ids=["fieldrig", "socketcand"])
def test_a_homing_of_a_minute_gives_the_same_bytes_each_time(where: dict[str, Any]) -> None:
    first = homed(where)
    assert first[0]
    assert 60 * S < first[1] < 64 * S
    assert homed(where) == first


@pytest.mark.long
def test_jitter_makes_other_runs_and_the_same_for_the_same_seed() -> None:
    runs = [homed(FIELDRIG, jitter=0.01, seed=seed)[3] for seed in (1, 2, 1)]
    assert runs[0] == runs[2] != runs[1]


def test_a_master_without_a_socket_hears_and_sends(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG) as bus:
        bus.send(can.Message(arbitration_id=0x60A, data=bytes.fromhex("40 00 10 00 00 00 00 00"), is_extended_id=False))
        heard = [bus.recv(1), bus.recv(1)]  # the boot-up message, and the answer
        answer = heard[1]
        assert answer is not None
        assert (answer.arbitration_id, bytes(answer.data)) == (0x58A, bytes.fromhex("43 00 10 00 92 01 ff ff"))
        before_s = time.monotonic()
        assert bus.recv(0.5) is None
        assert time.monotonic() - before_s == 0.5


def test_filters_of_python_can_apply(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG, can_filters=[{"can_id": 0x123, "can_mask": 0x7FF}]) as bus, can.Bus(**FIELDRIG) as other:
        for identifier in (0x122, 0x123):
            other.send(can.Message(arbitration_id=identifier, is_extended_id=False))
        heard = bus.recv(1)
        assert heard is not None
        assert heard.arbitration_id == 0x123


def test_a_notifier_a_cyclic_task_and_asyncio_work(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)

    async def main() -> list[float]:
        with can.Bus(**FIELDRIG) as bus, can.Bus(**FIELDRIG) as sender:
            reader = can.AsyncBufferedReader()
            with can.Notifier(bus, [reader], loop=asyncio.get_running_loop()):
                task = sender.send_periodic(can.Message(arbitration_id=0x123, is_extended_id=False), 0.1)
                instants: list[float] = []
                while len(instants) < 20:
                    message = await reader.get_message()
                    if message.arbitration_id == 0x123:
                        instants.append(message.timestamp)
                task.stop()
                return instants

    instants = asyncio.run(main())
    assert instants[-1] - instants[0] == pytest.approx(1.9, abs=0.001)


def test_an_unknown_bus_is_named(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with pytest.raises(can.CanInitializationError, match="no bus 'can1'"):
        can.Bus(interface="fieldrig", channel="can1")


def test_a_frame_that_no_bus_carries_is_refused(fieldrig_master: MasterRigMaker) -> None:
    fieldrig_master(AXES)
    with can.Bus(**FIELDRIG) as bus, pytest.raises(can.CanOperationError):
        bus.send(can.Message(arbitration_id=0x800, is_extended_id=False, check=False))
