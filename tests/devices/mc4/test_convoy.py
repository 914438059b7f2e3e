"""Drives of one process that are moved together do what each does alone."""

import subprocess
import sys
from random import Random

import pytest
from drive_line import CYCLE_NS, Line, course

from fieldrig_devices.mc4 import convoy, seat
from fieldrig_devices.mc4.axis import Mode
from fieldrig_devices.mc4.ring_side import RingSide


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
