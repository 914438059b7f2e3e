"""python canopen's `BaseNode402` works with a drive of each personality, and the recording alone tells which it was."""

import re
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import canopen
import pytest
from canopen.profiles.p402 import BaseNode402
from canopen.sdo.exceptions import SdoError
from made_rigs import keys_of, recorded, rig_file, save

from fieldrig import Rig, from_dict, virtual_time
from fieldrig.traces.trace import TraceEntry
from fieldrig_devices.cia402 import EDS
from fieldrig_devices.cia402.single.personality import Name

pytestmark = [pytest.mark.lean, pytest.mark.long, pytest.mark.timeout(120)]
NODE = 3
MASTER: Any = BaseNode402


def tried(act: Callable[[], Any]) -> None:
    """Do it; not every personality lets this master."""
    with suppress(RuntimeError, TypeError, SdoError):
        act()


def worked(personality: str | None, reset_s: int) -> list[TraceEntry]:
    """Record the drive: the master resets it, moves it to a position and at a speed, and homes it."""
    drive = {"kind": "cia402.drive", "node_id": NODE, "links": {"can": "can0"}, "personality": personality}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    with Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"axis": drive}})) as rig:
        entries = recorded(rig)
        with virtual_time(rig, limit_s=100):
            network: Any = canopen.Network()
            network.connect(interface="fieldrig", channel="can0")
            axis = MASTER(NODE, str(EDS))
            network.add_node(axis)
            time.sleep(reset_s)
            axis.nmt.send_command(0x81)
            axis.nmt.wait_for_bootup(10)
            for act in (
                lambda: axis.sdo[0x1000].raw,
                axis.setup_402_state_machine,
                lambda: setattr(axis.nmt, "state", "OPERATIONAL"),
                lambda: setattr(axis.sdo[0x1017], "raw", 200),
                lambda: time.sleep(0.3),
                lambda: setattr(axis, "op_mode", "PROFILED POSITION"),
                lambda: setattr(axis, "state", "OPERATION ENABLED"),
                lambda: setattr(axis.sdo[0x607A], "raw", 50_000),
                lambda: setattr(axis.sdo[0x6040], "raw", 0x1F),
                *[lambda: axis.sdo[0x6041].raw] * 30,
                lambda: setattr(axis, "op_mode", "PROFILED VELOCITY"),
                lambda: setattr(axis.sdo[0x60FF], "raw", 20_000),
                lambda: time.sleep(0.5),
                lambda: axis.homing(timeout=20),
                lambda: setattr(axis, "state", "SWITCH ON DISABLED"),
            ):
                tried(act)
            network.disconnect()
    return entries


@pytest.mark.parametrize("personality", [None, *Name.__args__])  # type: ignore[attr-defined]
@pytest.mark.parametrize("reset_s", [2, 7], ids=["some-boot-still", "all-are-on"])
def test_a_recording_tells_the_personality(tmp_path: Path, personality: str | None, reset_s: int) -> None:
    """A log of candump knows no senders.  A drive that boots for longer than 2 s has not heard the first reset."""
    rig = rig_file(save(worked(personality, reset_s), tmp_path / "drive.log"))
    device = keys_of(rig)["devices"]["node3"]
    assert (device["kind"], device.get("personality")) == ("cia402.drive", personality)
    (fitting,) = re.findall(r"(\d+) of (\d+) signs", rig.read_text(encoding="utf-8"))
    assert fitting[0] == fitting[1]
