"""Keys of the keyboard and of binary inputs, with their modes."""

import pytest
from smart_io_bench import SmartIoBench

from fieldrig_devices.pamring.frames import InputChanged, KeyItem, KeyMode, SetOutput

START = KeyItem(7, 12, False, KeyMode.ON_OFF, 50)
STEPS = KeyItem(8, 18, False, KeyMode.AUTOREPEAT, 50, 1500, 500)
DEPORTED = KeyItem(9, 103, True, KeyMode.TOGGLE, 20, debounce=2)
"""The keys of the manual's samples (lines 1508 to 1557)."""


def changes(bench: SmartIoBench, time_ms: int) -> list[tuple[int, int]]:
    """The instants in ms at which the value changes, with the values."""
    found = []
    for now in range(1, time_ms + 1):
        bench.run(1)
        found += [(now, value) for _, value in bench.inputs()]
    return found


@pytest.mark.manual("PAML-087")
@pytest.mark.manual("PAML-090")
def test_a_key_of_the_keyboard_follows_its_position_in_the_key_array() -> None:
    bench = SmartIoBench()
    bench.configure(START)
    bench.wire("start", True)
    assert changes(bench, 60) == [(50, 1)]
    bench.wire("start", False)
    assert changes(bench, 60) == [(40, 0)]


@pytest.mark.manual("PAML-088")
@pytest.mark.manual("PAML-091")
def test_each_press_of_a_toggle_key_on_a_binary_input_inverts_its_value() -> None:
    bench = SmartIoBench()
    bench.configure(DEPORTED)
    values = []
    for level in (True, False, True, False):
        bench.wire("button", level)
        values += changes(bench, 105)
    assert values == [(40, 1), (30, 0)], "two samples of 20 ms, and nothing when it is released"


@pytest.mark.manual("PAML-089")
def test_an_autorepeat_key_rises_again_after_delay_and_then_with_each_repeat() -> None:
    bench = SmartIoBench(terminals={})
    bench.configure(STEPS)
    bench.set("key18", True)
    found = changes(bench, 3_105)
    assert found == [(50, 1), (1500, 0), (1550, 1), (2000, 0), (2050, 1), (2500, 0), (2550, 1), (3000, 0), (3050, 1)]
    bench.set("key18", False)
    assert changes(bench, 2_000) == [(45, 0)], "released: no more repetitions"
    assert bench.clock.next_ns() is None


@pytest.mark.manual("PAML-089")
def test_an_autorepeat_key_without_repeat_is_pressed_once() -> None:
    bench = SmartIoBench(terminals={})
    bench.configure(KeyItem(8, 18, False, KeyMode.AUTOREPEAT, 50))
    bench.set("key18", True)
    assert changes(bench, 3_000) == [(50, 1)]


def test_a_key_that_is_active_low_is_pressed_while_its_level_is_low() -> None:
    bench = SmartIoBench()
    bench.configure(KeyItem(7, 103, True, KeyMode.ON_OFF, 10, is_active_high=False))
    bench.wire("button", True)
    assert changes(bench, 25) == [(10, 0)]
    bench.wire("button", False)
    assert changes(bench, 25) == [(5, 1)]


@pytest.mark.manual("PAML-092")
def test_a_program_sets_a_key_until_the_key_changes_it() -> None:
    bench = SmartIoBench()
    bench.configure(START, DEPORTED)
    bench.order(SetOutput(7, 1, number=21), SetOutput(9, 1, number=22))
    assert bench.port.take() == [InputChanged(7, 1, number=21), InputChanged(9, 1, number=22)]
    bench.wire("start", True)
    bench.run(50)
    bench.wire("start", False)
    bench.wire("button", True)
    bench.run(50)
    assert bench.port.take() == [InputChanged(9, 0, number=22), InputChanged(7, 0, number=21)]
