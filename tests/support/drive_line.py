"""A controller and some drives in virtual time, which swing while things happen to them."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from math import cos, tau
from pathlib import Path
from random import Random
from typing import Any

from device_of import device_of
from inner_state import Plain, inner_state
from ring_lab import Follower

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config.rig_file import from_dict
from fieldrig.virtual.rig import Rig
from fieldrig_devices.max4.controller import Max4
from fieldrig_devices.mc4.drive import Mc4

PLATE = Path(__file__).parents[2] / "configs/plates/sm-100-30-080.yaml"
CYCLE_NS = 4 * MS
LOOK = 8
"""Events between two looks into the drives."""
GEARED = {"coulomb_nm": 0.05, "gear_ratio": 7.5, "viscous_nm_s_per_rad": 0.001}
TWISTING = {"inertia_kg_m2": 4e-4, "stiffness_nm_per_rad": 40.0, "damping_nm_s_per_rad": 0.05}


@dataclass
class Swing:
    """A motion to and fro around the starting position."""

    width: float
    cycles_a_turn: float

    def at(self, cycles: float) -> float:
        return self.width * (1 - cos(tau * cycles / self.cycles_a_turn))


@dataclass
class Line:
    """A controller and its drives, whose `loads` are those given, in turn; `more` is what else they have in common."""

    count: int
    wires: bool = False
    loads: Sequence[Mapping[str, float]] = ({},)
    more: Mapping[str, Any] = field(default_factory=dict)
    said: list[str] = field(default_factory=list)
    swings: list[Swing] = field(default_factory=list)
    inside: list[list[dict[str, Plain]]] = field(default_factory=list)
    """The inner states of all drives, each time that `look` was called."""
    followed: int = 0
    """Drives that followed their set positions by one function, counted after each run."""

    def __post_init__(self) -> None:
        links = {"ring": "ring", "wires": "wires"} if self.wires else {"ring": "ring"}
        drive = {"kind": "mc4", "motor": {"name_plate": str(PLATE)}, "links": links, **self.more}
        names = {f"d{number}": {"ring_address": number} for number in range(1, self.count + 1)}
        config = {
            "time": "virtual",
            "buses": {"ring": {"kind": "ring.virtual"}, "wires": {"kind": "wires.virtual"}},
            "devices": {
                "max4": {"kind": "max4", "links": {"ring": "ring"}, "cycle_ms": 4, "drives": names},
                **{
                    name: {**drive, **address, "load": self.loads[place % len(self.loads)]}
                    for place, (name, address) in enumerate(names.items())
                },
            },
        }
        self.rig = Rig(from_dict(config), self._on_delivery)
        self.rig.run_until(5 * S)
        for name in names:
            self.rig.set("max4", f"{name}.ControllerEnable", True)
        self.rig.run_until(5500 * MS)
        self.max4 = device_of(self.rig, "max4", Max4)
        self.drives = [device_of(self.rig, name, Mc4) for name in names]

    def _on_delivery(self, bus: Bus[Any], delivery: Delivery[Any]) -> None:
        self.said.append(f"{bus.name} {delivery.time_ns} {delivery.sender} {delivery.message!r}")

    def swing(self, random: Random) -> None:
        for axis in self.max4.firmware.axes.values():
            self.swings.append(Swing(random.choice([2e4, 3e5, 8e5]), random.uniform(300, 800)))
            axis.follow(Follower(self.swings[-1].at, 1))

    def run(self, cycles: int) -> None:
        self.rig.run_until(self.rig.now_ns + cycles * CYCLE_NS)
        self.followed += sum(drive._side is not None and drive._side._following is not None for drive in self.drives)

    def look(self) -> None:
        """Keep everything that is in the drives now."""
        self.inside.append([inner_state(drive) for drive in self.drives])


def events(line: Line, random: Random) -> list[Callable[[], object]]:
    number = random.randrange(line.count)
    name, axis = f"d{number + 1}", list(line.max4.firmware.axes.values())[number]
    wide = random.choice([0.0, 2e3, 8e5, 8e6])
    telegram = random.choice(["mst", "mdt", "at"])
    distort = {"what": "distort", "station": name, "telegram": telegram, "count": 1}

    def note(answer: object) -> None:
        line.said.append(f"{line.rig.now_ns} {answer!r}")

    return [
        lambda: setattr(line.swings[number], "width", wide),
        lambda: line.rig.set(name, "load_torque", random.uniform(-2, 2)),
        lambda: line.rig.set(name, "load_torque", random.choice([0.0, 0.02, 0.05, -0.05, 0.375])),
        lambda: line.run(random.choice([20, 60])),
        lambda: note(line.rig.get(name, random.choice(["speed", "torque", "load_position", "motor_temperature"]))),
        lambda: axis.read(random.choice([51, 40, 84, 383, 13, 11]), note),
        lambda: axis.write(104, random.randrange(500, 3000).to_bytes(2, "little"), note),
        lambda: line.rig.add_fault("ring", distort),
        lambda: line.rig.add_fault("ring", {"what": "break", "after": name, "duration_ms": 3}),
        lambda: line.rig.add_fault("ring", {"what": "off", "station": name, "duration_ms": 3}),
        lambda: line.rig.add_fault(name, {"what": "enable_lost", "duration_ms": 20}),
        lambda: line.rig.set("max4", f"{name}.ControllerEnable", random.random() < 0.5),
        lambda: line.rig.set("max4", "DiagQuit", True),
        lambda: None,
    ]


def course(seed: int, wires: bool, loads: Sequence[Mapping[str, float]] = (GEARED, {})) -> Line:
    """Return the trace of five drives during random events."""
    random = Random(seed)
    line = Line(5, wires, loads)
    line.swing(random)
    line.run(20)
    for number in range(40):
        random.choice(events(line, random))()
        line.run(random.randrange(1, 18))
        if number % LOOK == LOOK - 1:
            line.look()
    return line
