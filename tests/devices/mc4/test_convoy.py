"""Drives of one process that are moved together do what each does alone."""

import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass, field
from math import cos, tau
from pathlib import Path
from random import Random
from typing import Any

import pytest
from device_of import device_of
from ring_lab import Follower

from fieldrig.bus import Bus, Delivery
from fieldrig.clock import MS, S
from fieldrig.config import from_dict
from fieldrig.rig import Rig
from fieldrig_devices.max4.controller import Max4
from fieldrig_devices.mc4 import convoy, seat
from fieldrig_devices.mc4.axis import Mode
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.ring_side import RingSide

PLATE = Path(__file__).parents[3] / "configs/plates/sm-100-30-080.yaml"
CYCLE_NS = 4 * MS


@dataclass
class Swing:
    """To and fro from where it stood."""

    width: float
    cycles_a_turn: float

    def at(self, cycles: float) -> float:
        return self.width * (1 - cos(tau * cycles / self.cycles_a_turn))


@dataclass
class Line:
    """A controller and its drives; where they are mixed, each second one has a gear and dry friction."""

    count: int
    wires: bool = False
    is_mixed: bool = False
    said: list[str] = field(default_factory=list)
    swings: list[Swing] = field(default_factory=list)
    rides: int = 0

    def __post_init__(self) -> None:
        links = {"ring": "ring", "wires": "wires"} if self.wires else {"ring": "ring"}
        drive = {"kind": "mc4", "motor": {"name_plate": str(PLATE)}, "links": links}
        geared = {"coulomb_nm": 0.05, "gear_ratio": 7.5, "viscous_nm_s_per_rad": 0.001} if self.is_mixed else {}
        names = {f"d{number}": {"ring_address": number} for number in range(1, self.count + 1)}
        config = {
            "time": "virtual",
            "buses": {"ring": {"kind": "ring.virtual"}, "wires": {"kind": "wires.virtual"}},
            "devices": {
                "max4": {"kind": "max4", "links": {"ring": "ring"}, "cycle_ms": 4, "drives": names},
                **{
                    name: {**drive, **address, "load": geared if address["ring_address"] % 2 else {}}
                    for name, address in names.items()
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
        for axis in self.max4.axes.values():
            self.swings.append(Swing(random.choice([2e4, 3e5, 8e5]), random.uniform(300, 800)))
            axis.follow(Follower(self.swings[-1].at, 1))

    def run(self, cycles: int) -> None:
        self.rig.run_until(self.rig.now_ns + cycles * CYCLE_NS)
        self.rides += self.riding

    @property
    def riding(self) -> int:
        return sum(drive.machine.ride is not None for drive in self.drives)

    def states(self) -> list[tuple[object, ...]]:
        machines = [drive.machine for drive in self.drives]
        return [
            (
                one.at_ns,
                axis.set_increments,
                axis.e,
                axis.v,
                axis.i,
                axis.t,
                axis.heats,
                axis.works,
                one.thermal.motor_c,
            )
            for one in machines
            for axis in [one.axis]
        ]


def events(line: Line, random: Random) -> list[Callable[[], object]]:
    number = random.randrange(line.count)
    name, axis = f"d{number + 1}", list(line.max4.axes.values())[number]
    wide = random.choice([0.0, 2e3, 8e5, 8e6])
    telegram = random.choice(["mst", "mdt", "at"])
    distort = {"what": "distort", "station": name, "telegram": telegram, "count": 1}

    def note(answer: object) -> None:
        line.said.append(f"{line.rig.now_ns} {answer!r}")

    return [
        lambda: setattr(line.swings[number], "width", wide),
        lambda: line.rig.set(name, "load_torque", random.uniform(-2, 2)),
        lambda: note(line.rig.get(name, random.choice(["speed", "motor_temperature"]))),
        lambda: axis.read(random.choice([51, 40, 383, 13, 11]), note),
        lambda: axis.write(104, random.randrange(500, 3000).to_bytes(2, "little"), note),
        lambda: line.rig.add_fault("ring", distort),
        lambda: line.rig.add_fault("ring", {"what": "break", "after": name, "duration_ms": 3}),
        lambda: line.rig.add_fault("ring", {"what": "off", "station": name, "duration_ms": 3}),
        lambda: line.rig.add_fault(name, {"what": "enable_lost", "duration_ms": 20}),
        lambda: line.rig.set("max4", f"{name}.ControllerEnable", random.random() < 0.5),
        lambda: line.rig.set("max4", "DiagQuit", True),
        lambda: None,
    ]


def course(seed: int, wires: bool) -> Line:
    random = Random(seed)
    line = Line(5, wires, is_mixed=True)
    line.swing(random)
    line.run(20)
    for _ in range(40):
        random.choice(events(line, random))()
        line.run(random.randrange(1, 18))
    return line


@pytest.mark.parametrize(("seed", "wires"), [(1, False), (2, True), (3, False), (4, True)])
def test_what_drives_say_and_do_is_the_same_alone_and_together(
    monkeypatch: pytest.MonkeyPatch, seed: int, wires: bool
) -> None:
    alone = course(seed, wires)
    for module in (seat, convoy):
        monkeypatch.setattr(module, "FEWEST", 3)
    monkeypatch.setattr(convoy, "FEWER", 2)
    together = course(seed, wires)
    assert together.rides > 20
    assert alone.rides == 0
    assert together.said == alone.said
    assert together.states() == alone.states()


def test_many_that_follow_ride_and_few_go_alone() -> None:
    many, few = Line(seat.FEWEST), Line(seat.FEWEST - 1)
    for line in (many, few):
        line.swing(Random(1))
        line.run(10)
    assert (many.riding, few.riding) == (seat.FEWEST, 0)


def test_ride_ends_for_whoever_is_asked_and_goes_on() -> None:
    line = Line(seat.FEWEST)
    line.swing(Random(1))
    line.run(10)
    line.rig.get("d3", "following_error")
    assert line.riding == seat.FEWEST - 1
    line.run(2)
    assert line.riding == seat.FEWEST


def test_drive_that_was_looked_at_since_its_turn_goes_alone() -> None:
    line = Line(seat.FEWEST + 1)
    first, second = line.drives[:2]
    assert second._side is not None
    second._side.on_moved = lambda: first.machine.look()  # as if a wire had said something
    second.machine.look()
    for drive in line.drives:
        assert drive.machine.axis.is_stiff  # who is asked rides no more
    line.run(1)
    assert line.riding == seat.FEWEST - 1
    assert (first.machine.ride, second.machine.ride) == (None, None)


@pytest.mark.parametrize(("late_ns", "rides"), [(CYCLE_NS // 8, True), (CYCLE_NS // 5, False)])
def test_drive_whose_time_is_another_rides_if_it_is_near(late_ns: int, rides: bool) -> None:
    line = Line(seat.FEWEST + 1)
    other, machine = (drive.machine for drive in line.drives[2:4])
    for one in (other, machine):
        assert one.axis.mode is Mode.POSITION  # who is asked rides no more
    machine.at_ns -= late_ns
    line.run(10)
    assert line.riding == seat.FEWEST + rides
    for one in (other, machine):
        assert one.axis.mode is Mode.POSITION
    assert other.at_ns - machine.at_ns == late_ns


def test_position_that_no_float_holds_is_gone_alone() -> None:
    line = Line(seat.FEWEST + 1)
    axis = line.drives[3].machine.axis
    axis.put(axis.set_increments + (1 << 60))  # the same on the ring
    line.swing(Random(1))
    line.run(10)
    assert line.riding == seat.FEWEST
    assert line.drives[3].machine.ride is None


def test_drive_that_misses_its_telegram_goes_on_from_the_last_that_the_convoy_heard(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    line = Line(seat.FEWEST)
    line.swing(Random(1))
    line.run(20)
    machine = line.drives[3].machine
    missed: list[tuple[int, int]] = []

    def spy(side: RingSide, values: tuple[int, ...]) -> tuple[int, bytes]:
        missed.append((values[2], machine.axis.set_increments + machine.axis.way))
        return side.status(), side.feedback()

    monkeypatch.setattr(RingSide, "on_missed_cycle", spy)
    line.rig.add_fault("ring", {"what": "distort", "station": "d4", "telegram": "mdt", "count": 1})
    assert machine.ride is not None
    line.run(2)
    assert [one == other for one, other in missed] == [True]


def test_convoy_is_given_up_when_too_few_are_left() -> None:
    line = Line(seat.FEWEST)
    line.swing(Random(1))
    line.run(10)
    for number in range(1, seat.FEWEST - convoy.FEWER + 1):
        line.rig.set("max4", f"d{number}.ControllerEnable", False)
    line.run(10)
    assert line.riding == 0


def test_process_of_a_single_drive_has_no_arrays() -> None:
    words = "import sys, fieldrig_devices.mc4.drive; print('fieldrig_devices.mc4.convoy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", words], capture_output=True, text=True, check=True)
    assert done.stdout == "False\n"
