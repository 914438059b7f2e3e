"""Simulated axes and the motion libraries, in the order of the real-time process, without a compiler."""

from collections.abc import Mapping
from itertools import pairwise
from typing import Any, cast

from fieldrig.clock import MS, S
from fieldrig_devices.iec.host import Library, Results
from fieldrig_devices.max4.axes.axis import INCREMENTS, Axis
from fieldrig_devices.max4.axes.encoder import LogicEncoder
from fieldrig_devices.max4.axes.simulated import SimulatedDrive
from fieldrig_devices.max4.configuration.tree import ObjectTree
from fieldrig_devices.max4.libraries.collection import motion_libraries
from fieldrig_devices.max4.messages.diagnosis import Diagnosis

CYCLE_NS = 4 * MS
NO_SETPOS, ABSOLUTE, RELATIVE = 0, 1, 2

PINS = {
    "lAxisId": 0, "lEncId": 0, "lProfilId": 0,
    "lrXOffset": 0.0, "lrYOffset": 0.0, "lrXFactor": 1.0, "lrYFactor": 1.0,
    "lrXLimMin": 0.0, "lrXLimMax": 0.0, "bXLimMinOn": False, "bXLimMaxOn": False,
    "iXSetposMode": ABSOLUTE, "lrXSetposPos": 0.0, "iYSetposMode": ABSOLUTE, "lrYSetposPos": 0.0,
    "bReset": True,
}  # fmt: skip
"""The pins of CAM in the order of their declaration."""


class CamBench:
    """The bench, which is also the `MotionController` of the libraries."""

    cycle_ns = CYCLE_NS

    def __init__(self, *names: str, feed: float = INCREMENTS / 1000, files: Mapping[str, bytes] | None = None) -> None:
        """`feed` is the way of one revolution in units: 1000 increments are one unit here."""
        self.feed, self.files = feed, dict(files or {})
        tree = ObjectTree()
        self.axes: dict[str, Axis] = {}
        self.drives: list[SimulatedDrive] = []
        self.master = LogicEncoder(tree.root.add("Logic encoder", "LOGIC_ENC", "Master"))
        self.other = LogicEncoder(tree.root.add("Logic encoder", "LOGIC_ENC", "Other"))
        for number, name in enumerate(names or ("belt",), start=1):
            node = tree.root.add("MC-4", "MC_4", name)
            axis = self.axes[name] = Axis(name, node, number, Diagnosis(lambda: None), is_simulated=True)
            drive = SimulatedDrive(axis, CYCLE_NS)
            self.drives.append(drive)
            drive.start()
            axis.enable(True)
        self.libraries: list[Library] = motion_libraries(self)
        self.places: list[list[float]] = []
        """The set positions of all axes in each cycle, in units."""
        self.run(40)
        self.places.clear()

    # ---- the controller of the libraries

    def axis(self, address: int) -> Axis | None:
        return next((axis for axis in self.axes.values() if axis.log_adr == address), None)

    def encoder(self, address: int) -> LogicEncoder | None:
        return next((found for found in (self.master, self.other) if found.object.log_adr == address), None)

    def increments_per_unit(self, axis: Axis) -> float:
        return INCREMENTS / self.feed if self.feed else 0.0

    def read_file(self, name: str) -> bytes:
        if name.upper() not in self.files:
            raise ValueError(f"no file {name}")
        return self.files[name.upper()]

    # ---- what a program does

    def call(self, function: str, *inputs: Any) -> Any:
        """Return the result of a function."""
        found = next(of.functions[function.lower()] for of in self.libraries if function.lower() in of.functions)
        return cast(Results, found.run(*inputs))[0]

    def block(self, name: str, address: int, *inputs: Any) -> tuple[Any, ...]:
        """Return the outputs of a block; `address` is that of its instance."""
        found = next(of.blocks[name.lower()] for of in self.libraries if name.lower() in of.blocks)
        return cast(Results, found.run(address, *inputs))

    def cam(
        self, profile: int, axis: str = "belt", *, instance: int = 100, kind: str = "CAM", **pins: Any
    ) -> tuple[Any, ...]:
        """Call an instance of CAM on the logic encoder; pins that are not given have the values of `PINS`."""
        given = {"lAxisId": self.axes[axis].log_adr, "lEncId": self.master.object.log_adr, "lProfilId": profile} | pins
        assert given.keys() <= PINS.keys()
        return self.block(kind, instance, *(PINS | given).values())

    def part(self, profile: int, length: float, height: float, **pins: Any) -> tuple[Any, ...]:
        """Call CAM for one part with both limits, as the manual's program does."""
        return self.cam(
            profile, lrXFactor=length, lrYFactor=height, lrXLimMax=length, bXLimMinOn=True, bXLimMaxOn=True, **pins
        )

    def run(self, cycles: int) -> None:
        for _ in range(cycles):
            for drive in self.drives:
                drive.take()
            self.master.step(CYCLE_NS)
            self.other.step(CYCLE_NS)
            for drive in self.drives:
                drive.give()
            self.places.append([float(axis.set_value) / 1000 for axis in self.axes.values()])

    # ---- what has happened

    def place(self, axis: str = "belt") -> float:
        """The present set position in units."""
        return float(self.axes[axis].set_value) / 1000

    def speeds(self, number: int = 0) -> list[float]:
        """The set velocities of an axis from cycle to cycle, in units per second."""
        places = [places[number] for places in self.places]
        return [(after - before) * S / CYCLE_NS for before, after in pairwise(places)]
