"""A MAx-4 with MC-4 drives or simulated ones, and python canopen as the master at its CAN end, in virtual time."""

from functools import cache, partial
from pathlib import Path
from typing import Any, cast

import canopen
from canopen.profiles.p402 import BaseNode402
from device_of import device_of

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.max4.axes.axis import Axis
from fieldrig_devices.max4.can.objects import EDS
from fieldrig_devices.max4.controller import Max4

PLATE = str(Path(__file__).parents[2] / "configs" / "plates" / "sm-100-30-080.yaml")
NODE = 10


class PatientNode402(BaseNode402):
    """Waits by the rig's time, which passes with each answer, and not by the wall clock."""

    TIMEOUT_RESET_FAULT = 0.0
    TIMEOUT_SWITCH_OP_MODE = TIMEOUT_SWITCH_STATE_FINAL = TIMEOUT_SWITCH_STATE_SINGLE = 120.0
    TIMEOUT_HOMING_DEFAULT = 120


@cache
def dictionary_of(eds: str, node_id: int) -> Any:
    """Return what python canopen reads from an EDS; it takes 0.3 s for that of a controller, and never changes it."""
    return canopen.import_od(eds, node_id)


class Wire(canopen.Network):
    def __init__(self, bench: "CanFaceBench") -> None:
        super().__init__()
        self._bench = bench

    def add_node(self, node: Any, object_dictionary: Any = None, upload_eds: bool = False) -> Any:
        if isinstance(object_dictionary, str):
            object_dictionary = dictionary_of(object_dictionary, node)
        return super().add_node(node, object_dictionary, upload_eds)

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        self._bench.outside.link("can0").send(CanFrame(can_id, bytes(data), is_remote=remote))
        self._bench.run(2)


class CanFaceBench:
    """`drives` are MC-4 on a ring, `simulated` have no drive; other keywords are settings of the controller."""

    def __init__(
        self,
        *drives: str,
        simulated: tuple[str, ...] = (),
        can_axes: dict[str, Any] | None = None,
        store: MemoryStore | None = None,
        **settings: Any,
    ) -> None:
        axes: dict[str, Any] = {name: {"ring_address": place} for place, name in enumerate(drives, 1)}
        axes |= {name: {"ring_address": 100 + place, "simulated": True} for place, name in enumerate(simulated)}
        devices: dict[str, Any] = {
            "max4": {
                "kind": "max4",
                "links": {"ring": "ring0", "wires": "wires", "can": "can0"},
                "drives": axes,
                "can_axes": can_axes or {"node_ids": [NODE]},
                **settings,
            }
        }
        for place, name in enumerate(drives, 1):
            devices[name] = {
                "kind": "mc4",
                "ring_address": place,
                "motor": {"name_plate": PLATE},
                "links": {"ring": "ring0"},
            }
        buses = {
            "ring0": {"kind": "ring.virtual"},
            "wires": {"kind": "wires.virtual"},
            "can0": {"kind": "can.virtual", "bitrate": 1_000_000},
        }
        self.store = store or MemoryStore()
        self.frames: list[str] = []
        config = from_dict({"time": "virtual", "seed": 7, "buses": buses, "devices": devices})
        self.rig = Rig(config, stores={"max4": self.store})
        self.outside = self.rig.attach("outside")
        self.outside.link("can0").on_receive(self._on_frame, [[0, 0]])
        self.wire = Wire(self)

    def _on_frame(self, frame: CanFrame) -> None:
        self.frames.append(f"{frame.identifier:03X}#{frame.data.hex(' ')}")
        self.wire.notify(frame.identifier, bytearray(frame.data), self.rig.now_ns / 1e9)

    @property
    def max4(self) -> Max4:
        return device_of(self.rig, "max4", Max4)

    def axis(self, name: str) -> Axis:
        return self.max4.firmware.axes[name]

    def run(self, ms: float) -> "CanFaceBench":
        self.rig.run_until(self.rig.now_ns + round(ms * MS))
        return self

    def boot(self) -> "CanFaceBench":
        """Run until the controller and its ring are up, and drives have read their name plates."""
        while not self.max4.firmware.is_booted:
            self.run(10)
        return self.run(1_500)

    def take(self) -> list[str]:
        frames, self.frames = self.frames, []
        return frames

    def send(self, text: str) -> list[str]:
        """A frame; what came out within 2 ms."""
        identifier, _, data = text.partition("#")
        self.take()
        self.outside.link("can0").send(CanFrame(int(identifier, 16), bytes.fromhex(data)))
        self.run(2)
        return self.take()

    def master(self, node_id: int = NODE) -> Any:
        """python canopen's CiA 402 master, with the node operational."""
        node: Any = cast(Any, PatientNode402)(node_id, dictionary_of(str(EDS), node_id))  # canopen has no types
        self.wire.add_node(node)
        node.nmt.state = "OPERATIONAL"
        self.run(10)
        for pdo in node.tpdo.values():
            pdo.wait_for_reception = partial(self.wait_for, pdo)
        return node

    def wait_for(self, pdo: Any, timeout: float = 10) -> float | None:
        """Wait as canopen does, while time passes."""
        before = pdo.timestamp
        for _ in range(round(timeout * 1000)):
            if pdo.timestamp != before:
                break
            self.run(1)
        found: float | None = pdo.timestamp
        return found
