"""A homing of a minute by python canopen, unchanged, in virtual time; for tests and benchmarks."""

import hashlib
import threading
import time
from typing import Any

import canopen
from canopen.profiles.p402 import BaseNode402

from fieldrig import Bus, Delivery, Rig, from_dict, virtual_time
from fieldrig_devices.max4 import EDS

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
