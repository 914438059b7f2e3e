"""A controller on a bench: its ring with MC-4 drives, its wires, under virtual time."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any, Self

from device_of import device_of
from max4_rig import Max4Rig

from fieldrig.clock import MS
from fieldrig.config.rig_file import from_dict
from fieldrig.storage.store import MemoryStore
from fieldrig.virtual.rig import Rig
from fieldrig_bus.wires import Signal
from fieldrig_devices.max4.axes.axis import Axis, Mode
from fieldrig_devices.mc4.drive import Mc4

MAX4 = "fieldrig_devices.max4.controller:Max4"
MC4 = "fieldrig_devices.mc4.drive:Mc4"
PLATE = str(Path(__file__).parents[2] / "configs" / "plates" / "sm-100-30-080.yaml")


class Bench(Max4Rig):
    """`drives` are names of MC-4 with ring addresses from 1 on; other keywords are settings of the controller."""

    def __init__(
        self,
        *drives: str,
        simulated: tuple[str, ...] = (),
        store: MemoryStore | None = None,
        ring: dict[str, Any] | None = None,
        addresses: dict[str, int] | None = None,
        of_drives: dict[str, dict[str, Any]] | None = None,
        **settings: Any,
    ) -> None:
        self.addresses = addresses or {name: place for place, name in enumerate(drives, 1)}
        axes: dict[str, Any] = {name: {"ring_address": address} for name, address in self.addresses.items()}
        axes |= {name: {"ring_address": 100 + place, "simulated": True} for place, name in enumerate(simulated)}
        buses = {"ring0": {"kind": "ring.virtual", **(ring or {})}, "wires": {"kind": "wires.virtual"}}
        devices: dict[str, Any] = {
            "max4": {
                "kind": MAX4,
                "language": "de",  # as the manual prints its messages
                "links": {"ring": "ring0", "wires": "wires"},
                "drives": axes | settings.pop("more_drives", {}),
                **settings,
            }
        }
        for name, address in self.addresses.items():
            devices[name.lower()] = {
                "kind": MC4,
                "ring_address": address,
                "motor": {"name_plate": PLATE},
                "links": {"ring": "ring0"},
                **(of_drives or {}).get(name, {}),
            }
        config = from_dict({"time": "virtual", "seed": 7, "buses": buses, "devices": devices})
        self.store = store or MemoryStore()
        self.wires: list[tuple[int, str, Any]] = []
        self.rig = Rig(config, self._on_delivery, {"max4": self.store})
        self.outside = self.rig.attach("outside")

    def _on_delivery(self, bus: Any, delivery: Any) -> None:
        if isinstance(delivery.message, Signal):
            self.wires.append((delivery.time_ns, delivery.message.name, delivery.message.value))

    def drive(self, name: str) -> Mc4:
        return device_of(self.rig, name.lower(), Mc4)

    def clock_shows(self, ms: int) -> Self:
        """Time passes on the controller's own clock and nothing happens, so that a test need not wait for hours."""
        with self.rig._present("max4"):
            self.max4.firmware._boot._zero_ns = self.rig.now_ns - ms * MS
        return self

    def boot(self, ms: float = 20_000) -> Self:
        """Run until the boot has finished."""
        end_ns = self.rig.now_ns + round(ms * MS)
        while not self.max4.firmware.is_booted and self.rig.now_ns < end_ns:
            self.run(1)
        assert self.max4.firmware.is_booted
        return self

    def do(self, words: str) -> Self:
        return self.set("command", words)

    def fault(self, where: str, **fault: Any) -> int:
        return self.rig.add_fault(where.lower(), fault)

    def heal(self, where: str, number: int) -> Self:
        self.rig.clear_fault(where.lower(), number)
        return self

    def log(self) -> list[str]:
        """Return the log as the tool shows it, newest first."""
        return self.max4.firmware.logger.lines()

    def enable(self, *names: str) -> Self:
        for name in names:
            self.set(f"{name}.ControllerEnable", True)
        return self.run(300)

    def signal(self, wire: str, value: float) -> Self:
        self.outside.link("wires").send(Signal(wire, value))
        return self


class GivenSetValues:
    """A source of the set values that a test gives, one per cycle; the last value is repeated."""

    def __init__(self, values: Iterator[float], mode: Mode = Mode.POSITION) -> None:
        self.mode = mode
        self._values = values
        self.asked = 0
        self.begun: list[int] = []
        self.ended = 0
        self.last: float = 0

    def begin(self, axis: Axis) -> None:
        self.begun.append(axis.position)
        self.last = axis.position if self.mode is Mode.POSITION else 0

    def next(self) -> float:
        self.asked += 1
        self.last = next(self._values, self.last)
        return self.last

    def end(self) -> None:
        self.ended += 1
