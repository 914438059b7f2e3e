"""A Smart-IO where the manual can be read in two ways: the key `readings` selects the reading."""

from typing import Any

import pytest
from smart_io_bench import COUNTER, MOTOR, SmartIoBench

from fieldrig_devices.pamring.frames import (
    AnalogItem,
    Answer,
    Blink,
    Display,
    InputChanged,
    InputItem,
    KeyItem,
    KeyMode,
    LedItem,
    Motor,
    MotorReport,
    Read,
    SetOutput,
    SevenSegmentItem,
    Trouble,
)

STEPS = KeyItem(8, 18, False, KeyMode.AUTOREPEAT, 50, 1500, 500)
"""The key of the manual's sample (lines 1534 to 1543)."""


def node(**readings: Any) -> SmartIoBench:
    return SmartIoBench(readings=readings)


def pressed(bench: SmartIoBench, key: KeyItem, time_ms: int) -> list[tuple[int, int]]:
    """Press a key, and return the instants in ms at which its value changes, with the values."""
    bench.configure(key)
    bench.set(f"key{key.address}", True)
    found = []
    for now in range(1, time_ms + 1):
        bench.run(1)
        found += [(now, value) for _, value in bench.inputs()]
    return found


@pytest.mark.parametrize(
    ("autorepeat", "changes"),
    [
        ("gaps", [(50, 1), (1500, 0), (1550, 1), (2000, 0), (2050, 1)]),
        ("pulses", [(50, 1), (100, 0), (1550, 1), (1600, 0), (2050, 1)]),
    ],
)
def test_a_repeated_key_has_gaps_or_pulses(autorepeat: str, changes: list[tuple[int, int]]) -> None:
    bench = SmartIoBench(terminals={}, readings={"autorepeat": autorepeat})
    assert pressed(bench, STEPS, 2_090) == changes
    bench.set("key18", False)
    bench.run(5_000)
    assert [value for _, value in bench.inputs()] == [0]
    assert bench.clock.next_ns() is None


def test_a_pulsed_key_that_does_not_repeat_is_one_pulse() -> None:
    bench = SmartIoBench(terminals={}, readings={"autorepeat": "pulses"})
    assert pressed(bench, KeyItem(8, 18, False, KeyMode.AUTOREPEAT, 50), 5_000) == [(50, 1), (100, 0)]


@pytest.mark.parametrize(("time_stamps", "age_us"), [(False, 0), (True, 16_500)])
def test_a_report_has_the_age_of_its_edge_or_none(time_stamps: bool, age_us: int) -> None:
    bench = node(time_stamps=time_stamps)
    bench.configure(InputItem(7, 103, 1, True, 10, 2))
    for ms, level in ((1, True), (1, False), (1.5, True)):  # it bounces
        bench.run(ms)
        bench.wire("button", level)
    bench.run(20)
    assert bench.port.take() == [InputChanged(7, 1, age_us)]


@pytest.mark.parametrize(("counts", "counted"), [("direction", [1, 2, 1, 0, -1]), ("up", [1, 2, 3, 4, 5])])
def test_a_counter_follows_the_direction_of_its_motor_or_counts_up(counts: str, counted: list[int]) -> None:
    bench = node(counts=counts)
    bench.configure_motor(braking=0)
    for distance in (2, -3):
        bench.move(Motor.RELATIVE_MOVE, distance)
        bench.pulse(abs(distance))
        bench.run(101)
    found = [report.value for report in bench.port.sent if isinstance(report, InputChanged) and report.item == COUNTER]
    assert found == counted


@pytest.mark.parametrize(("zero_at", "position"), [("edge", -3), ("rest", 0)])
def test_zero_is_at_the_edge_or_where_the_motor_stops(zero_at: str, position: int) -> None:
    bench = node(zero_at=zero_at)
    bench.configure_motor()
    bench.move(Motor.ZERO_POSITION, -1, 1)
    bench.pulse(4)
    bench.wire("motor.zero", True)
    bench.run(1)
    bench.pulse(3)  # it coasts
    bench.run(101)
    assert asked(bench) == position
    bench.move(Motor.ZERO_POSITION, -1, 1)  # it is there already
    assert asked(bench) == 0


def test_an_order_behind_a_search_for_zero_names_the_position_before_the_motor_stops() -> None:
    bench = node(zero_at="rest")
    bench.configure_motor()
    bench.move(Motor.ZERO_POSITION, -1, 1)
    bench.pulse(4)
    bench.wire("motor.zero", True)
    bench.run(1)
    bench.pulse(3)
    bench.move(Motor.RELATIVE_MOVE, -9)
    bench.pulse(2)
    bench.run(101)
    assert asked(bench) == -2


def asked(bench: SmartIoBench) -> int | None:
    bench.order(Read(1, MOTOR))
    answer = bench.port.sent[-1]
    assert isinstance(answer, Answer)
    return answer.value


@pytest.mark.parametrize(("stray_pulses", "pulses"), [(None, 3), (0, 1), (4, 5)])
def test_the_pulses_at_rest_with_which_a_position_is_lost(stray_pulses: int | None, pulses: int) -> None:
    bench = node(stray_pulses=stray_pulses)
    bench.configure_motor(braking=2)
    bench.pulse(pulses - 1)
    assert bench.get("error_word") == (0x4000 if pulses > 1 else 0)
    bench.pulse()
    assert bench.get("error_word") == 0x6000


def test_a_motor_that_does_not_stop_has_the_free_bit() -> None:
    bench = node()
    bench.configure_motor()
    bench.move(Motor.RUN, 1)
    bench.pulse(2)
    bench.move(Motor.STOP)
    bench.pulse(60)
    reports = [report for report in bench.port.sent if isinstance(report, MotorReport)]
    assert reports[-1] == MotorReport(MOTOR, True, 0xA000)
    troubles = [report for report in bench.port.sent if isinstance(report, Trouble)]
    assert {trouble.details for trouble in troubles} == {(MOTOR, 0x0F), (MOTOR, 0x11)}
    assert troubles[-1].word == 0xA000


def test_the_period_of_blinking_is_a_second() -> None:
    bench = node()
    bench.configure(LedItem(7, 6), SevenSegmentItem(8, 1, 1))
    bench.order(Blink(7, True), Display(8, ord("A")), Blink(8, True))
    for is_lit in (True, False, True):
        assert bench.get("led6") is is_lit
        assert bench.last("lamp") is is_lit
        assert bool(bench.get("display.segments")) is is_lit
        bench.run(500)


def test_the_analog_output_has_steps_of_a_millivolt() -> None:
    bench = node()
    bench.configure(AnalogItem(7, 1))
    bench.order(SetOutput(7, 2501))
    assert bench.get("analog1") == 2501
    assert bench.last("speed") == 2.501


def test_the_font_of_a_machine() -> None:
    bench = node(font={"z": "abdeg", "8": ""})
    bench.configure(SevenSegmentItem(8, 1, 1))
    for character, segments in (("z", "abdeg"), ("8", ""), ("A", "abcefg")):
        bench.order(Display(8, ord(character)))
        assert bench.get("display.segments") == segments
