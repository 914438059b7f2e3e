"""A drive that goes straight from its telegrams to its AT does what it does the long way."""

from math import tau
from random import Random
from typing import Any

import pytest
from drive_line import CYCLE_NS, GEARED, TWISTING, Line, course

from fieldrig.clock import MS, S
from fieldrig_bus.ring.message import Cycle, Straight
from fieldrig_devices.mc4.drive import Mc4
from fieldrig_devices.mc4.folded import RAD
from fieldrig_devices.mc4.machine import SLOW_NS
from fieldrig_devices.mc4.motor import INCREMENTS_PER_TURN
from fieldrig_devices.mc4.ring_side import RingSide
from fieldrig_devices.sercos import words
from fieldrig_devices.sercos.slave import SercosSlave


def go_the_long_way(_slave: SercosSlave, _straight: Straight | None) -> None:
    """Nothing is shorter."""


@pytest.mark.parametrize(("seed", "wires"), [(1, False), (2, True), (3, False), (4, True), (5, False), (6, True)])
def test_what_drives_say_and_do_is_the_same_either_way(monkeypatch: pytest.MonkeyPatch, seed: int, wires: bool) -> None:
    loads: tuple[dict[str, float], ...] = (GEARED, {}, TWISTING)
    straight = course(seed, wires, loads)
    monkeypatch.setattr(SercosSlave, "go_straight", go_the_long_way)
    long = course(seed, wires, loads)
    assert straight.straights > 20
    assert long.straights == 0
    assert straight.said == long.said
    assert straight.states() == long.states()


class OneStraight:
    """A drive that swings, and what it would say if it went straight now."""

    def __init__(self, **line: Any) -> None:
        self.line = Line(1, **line)
        self.line.swing(Random(1))
        self.line.run(20)
        (self.drive,) = self.line.drives
        side = self.drive._side
        assert side is not None
        self.slave, self.machine = side.slave, self.drive.machine
        self.go_on()
        while self.machine.next_slow_ns < self.next_ns + CYCLE_NS:
            self.go_on()
        length = self.slave.layout.mdt_length
        record = bytearray(length)
        start = self.slave.layout.position - 1
        control, info, wanted = self.slave.values[:3]
        record[start : start + 4] = control.to_bytes(2, "little") + info.to_bytes(2, "little")
        record[start + 4 : start + 8] = (wanted & 0xFFFF_FFFF).to_bytes(4, "little")
        self.telegrams = b"\xff\x04\xff" + bytes(record)

    def go_on(self) -> None:
        """To where it goes straight again."""
        self.line.run(1)
        while self.slave._straight is None:
            self.line.run(1)

    @property
    def straight(self) -> Straight:
        assert self.slave._straight is not None
        return self.slave._straight

    @property
    def next_ns(self) -> int:
        return self.machine.at_ns + CYCLE_NS

    def state(self) -> tuple[object, ...]:
        axis = self.machine.axis
        return (
            self.machine.at_ns,
            self.slave.heard,
            self.slave.values,
            *(getattr(axis, name) for name in ("e", "v", "i", "t", "way", "moved", "set_increments", "works", "heats")),
        )

    def refuses(self, telegrams: bytes, now_ns: int, start: int = 0) -> bool:
        before = self.state()
        at = self.straight(now_ns, telegrams, start)
        assert at is not None or self.state() == before
        return at is None


def test_undisturbed_cycle_is_taken_wherever_in_the_message_it_lies() -> None:
    one = OneStraight()
    heard, told = one.slave.heard, one.slave.values
    one.slave.values = ()
    at = one.straight(one.next_ns, b"head" + one.telegrams, 4)
    assert at is not None
    assert at[0] == 1
    assert int.from_bytes(at[1:3], "little") & words.IN_OPERATION == words.IN_OPERATION
    assert (one.slave.heard, one.slave.values) == (heard + 1, told)


@pytest.mark.parametrize(
    "disturbed",
    [
        lambda telegrams: telegrams[:-1],
        lambda telegrams: telegrams + b"\0",
        lambda telegrams: telegrams[2:],
        lambda telegrams: telegrams[:2],
        lambda telegrams: b"\xff\x00" + telegrams[2:],
        lambda telegrams: telegrams[:2] + b"\x01" + telegrams[3:],
    ],
    ids=["too short", "too long", "no MST", "no MDT", "CP0", "to another"],
)
def test_disturbed_telegrams_are_left_to_the_slave(disturbed: Any) -> None:
    one = OneStraight()
    assert one.refuses(disturbed(one.telegrams), one.next_ns)


@pytest.mark.parametrize("bit", range(16))
def test_control_bits_that_ask_for_something_are_left_to_drive_and_service_channel(bit: int) -> None:
    """All but IPOSYNC, the two real-time bits and the two that the standard leaves free."""
    one = OneStraight()
    word = 3 + one.slave.layout.position - 1 + bit // 8
    telegrams = bytearray(one.telegrams)
    telegrams[word] ^= 1 << bit % 8
    asks_nothing = 1 << bit in (words.IPOSYNC, words.REAL_TIME_1, words.REAL_TIME_2, 1 << 11, 1 << 12)
    assert one.refuses(bytes(telegrams), one.next_ns) is not asks_nothing


@pytest.mark.parametrize(("late_ns", "refuses"), [(-2 * MS, True), (-MS, False), (MS, False), (2 * MS, True)])
def test_cycle_of_another_time_is_left_to_the_drive(late_ns: int, refuses: bool) -> None:
    one = OneStraight()
    assert one.refuses(one.telegrams, one.next_ns + late_ns) is refuses


def test_slow_things_are_left_to_the_drive() -> None:
    one = OneStraight()
    one.machine.at_ns = one.machine.next_slow_ns - CYCLE_NS
    assert one.refuses(one.telegrams, one.machine.next_slow_ns)
    assert not one.refuses(one.telegrams, one.machine.next_slow_ns - 1)


def test_following_error_and_rest_are_left_to_the_drive() -> None:
    one = OneStraight()
    axis = one.machine.axis
    axis.e += 10 * tau
    assert one.refuses(one.telegrams, one.next_ns)
    axis.e -= 10 * tau
    axis.is_at_rest = True
    assert one.refuses(one.telegrams, one.next_ns)


def test_who_is_led_astray_is_told_anew_by_the_drive() -> None:
    one = OneStraight(wires=True)
    while one.refuses(one.telegrams, one.next_ns):
        one.go_on()
    one.machine.axis.set_increments += 5_000
    assert one.refuses(one.telegrams, one.next_ns)


@pytest.mark.parametrize(("told_speed", "refuses"), [(0.0, False), (0.1, True)])
def test_that_it_stands_is_told_by_the_drive(told_speed: float, refuses: bool) -> None:
    one = OneStraight(wires=True)
    machine, axis = one.machine, one.machine.axis
    axis.e = axis.v = axis.i = axis.t = axis.lead = 0.0
    axis.way = 0
    assert one.drive._side is not None
    assert one.drive._side.course is not None
    one.drive._side.course = one.drive._side.course._replace(
        position=axis.set_increments * RAD - told_speed * CYCLE_NS / S, speed=told_speed, time_ns=machine.at_ns
    )
    one.drive._side._go_straight(bytes(20), Cycle(0, b"", b""))
    assert one.refuses(one.telegrams, one.next_ns) is refuses


@pytest.mark.parametrize("load", [{}, {"gear_ratio": 7.5}, TWISTING], ids=["stiff", "geared", "twisting"])
def test_drive_goes_the_long_way_only_to_tell_and_to_look(monkeypatch: pytest.MonkeyPatch, load: Any) -> None:
    """Its shaft is some turns from where its encoder sees it."""
    long_ways: list[int] = []
    on_cycle = RingSide.on_cycle

    def spy(side: RingSide, values: tuple[int, ...]) -> tuple[int, bytes]:
        long_ways.append(line.rig.now_ns)
        return on_cycle(side, values)

    line = Line(1, wires=True, loads=(load,))
    line.drives[0].machine.shaft_offset = 3 * INCREMENTS_PER_TURN
    line.swing(Random(1))
    line.run(10)
    monkeypatch.setattr(RingSide, "on_cycle", spy)
    line.said.clear()
    line.run(600)
    told = {int(said.split()[1]) for said in line.said if said.startswith("wires ") and " d1 " in said}
    looks = 600 * CYCLE_NS // SLOW_NS + 1
    assert told <= set(long_ways)
    assert len(told) > 20
    assert len(set(long_ways) - told) <= looks


def test_drive_whose_shaft_is_told_in_every_cycle_goes_the_long_way() -> None:
    line = Line(1, wires=True, more={"shaft_wire": "press.shaft"})
    line.swing(Random(1))
    line.run(10)
    assert line.straight == 0


def changes(drive: Mc4) -> list[Any]:
    side = drive._side
    assert side is not None
    return [
        drive.machine.look,
        side._read_warnings,
        side._read_states,
        lambda: side.slave._on_command_end(True),
        lambda: side.slave._enter(0),
        lambda: drive.machine.set_load(0.1),
    ]


@pytest.mark.parametrize("change", range(6))
def test_whatever_changes_ends_it(change: int) -> None:
    one = OneStraight()
    changes(one.drive)[change]()
    assert one.slave._straight is None


def test_silent_master_is_noticed_at_the_same_instant_either_way() -> None:
    line = Line(1)
    line.swing(Random(1))
    line.rig.run_until(line.rig.now_ns + 20 * CYCLE_NS + CYCLE_NS * 9 // 10)
    assert line.straight == 1
    heard_ns = max(int(said.split()[1]) for said in line.said if said.startswith("ring") and "Cycle(" in said)
    assert line.max4.bus is not None
    line.max4.bus._drop_master()
    for at_ns, phase in ((heard_ns + CYCLE_NS * 5 // 2 - 1, 4), (heard_ns + CYCLE_NS * 5 // 2, 0)):
        line.rig.run_until(at_ns)
        assert {phase_of(drive) for drive in line.drives} == {phase}


def phase_of(drive: Mc4) -> int:
    assert drive._side is not None
    return drive._side.slave.phase
