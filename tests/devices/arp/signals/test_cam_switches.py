"""CAM1 to CAM6 (manual 5.11)."""

from collections.abc import Iterable
from typing import Literal

import pytest
from arp_signals import SignalsBench, SignalsCard
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.parameters import ParX
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import CamSwitch

A13 = """\
X1 EQU V1
X2 EQU V2
X3 EQU V3
X4 EQU V4
beg M
X1 == 1000
X2 == 2000
X3 == 3000
X4 == 4000
cam1 1, X2, X3, O101
cam2 1, X3, X4, O102
cam3 1, X3, X2, O103
cam4 1, X2, X1, O104
cam5 1, X2, X3, !O105
cam6 1, X3, X2, !O106
end"""
# Digest 15, cell by cell: up X1..X2, X2..X3, X3..X4, then down X4..X3, X3..X2, X2..X1.
SWEEP = {
    101: (0, 1, 0, 0, 0, 0),
    102: (0, 0, 1, 0, 0, 0),
    103: (0, 0, 0, 0, 1, 0),
    104: (0, 0, 0, 0, 0, 1),
    105: (1, 0, 1, 1, 1, 1),
    106: (1, 1, 1, 1, 0, 1),
}
UNIT = 1_000  # raw
TURN = 20_000  # units of the cyclic counters here


def armed(
    set_at: float, reset_at: float, at: float = 0, turn: int | None = None, wrap: Literal["travel", "jump"] = "travel"
) -> SignalsCard:
    """CAM3 on axis 2 and O102, armed with the axis at a position; with a `turn`, its counter runs from 0 to `turn`."""
    card = SignalsCard(readings=Readings(cam_wrap=wrap))
    if turn is not None:
        assert card.real_parameters.set_ram(2, ParX.COUNTER_MAXIMUM, turn * UNIT)
        assert card.real_parameters.set_ram(2, ParX.COUNTER_MINIMUM, 0)
    card.positions[2] = round(at * UNIT)
    card.arm_cam_switch(3, CamSwitch(2, round(set_at * UNIT), round(reset_at * UNIT), False, "O", 102))
    return card


def outputs(card: SignalsCard, positions: Iterable[float]) -> list[int]:
    """O102 after a control loop at each of these positions."""
    seen = []
    for position in positions:
        card.positions[2] = round(position * UNIT)
        card.loop()
        seen.append(card.O[102])
    return seen


@pytest.mark.manual("ARP-112")
@pytest.mark.parametrize("step", [1, 7, 250, 999])
def test_a13_six_cams_in_a_sweep_up_and_down(step: int) -> None:
    bench = SignalsBench(A13)
    bench.card.positions[1] = 500 * UNIT
    bench.run()
    up = range(500 + step, 4_500, step)
    for sweep, places in ((up, (0, 1, 2)), (reversed(up), (5, 4, 3))):
        for position in sweep:
            bench.card.positions[1] = position * UNIT
            bench.card.loop()
            for place, low in zip(places, (1_000, 2_000, 3_000), strict=True):
                if low < position < low + 1_000:
                    seen = {output: bench.card.O[output] for output in SWEEP}
                    assert seen == {output: row[place] for output, row in SWEEP.items()}, position
            if not 1_000 < position < 4_000:
                assert [bench.card.O[output] for output in SWEEP] == [0, 0, 0, 0, 1, 1]


@pytest.mark.manual("ARP-112")
def test_a_cam_is_off_on_both_of_its_values() -> None:
    assert outputs(armed(5_000, 15_000), (4_999.999, 5_000, 5_000.001, 14_999.999, 15_000)) == [0, 0, 1, 1, 0]
    assert outputs(armed(15_000, 5_000, 20_000), (15_000.001, 15_000, 14_999.999, 5_000.001, 5_000)) == [0, 0, 1, 1, 0]


@pytest.mark.manual("ARP-112")
def test_an_axis_at_rest_on_the_set_value_passes_it_when_it_leaves() -> None:
    assert outputs(armed(0, 5_000, at=0), (0, 1, 2)) == [0, 1, 1]


@pytest.mark.manual("ARP-112")
def test_a_cam_goes_off_when_the_axis_turns_back_over_the_set_value() -> None:
    assert outputs(armed(5_000, 15_000), (6_000, 5_500, 4_000, 5_500)) == [1, 1, 0, 1]


@pytest.mark.manual("ARP-112")
def test_entering_over_the_reset_value_leaves_it_off() -> None:
    assert outputs(armed(5_000, 15_000, at=16_000), (14_000, 6_000, 14_000, 16_000)) == [0, 0, 0, 0]


@pytest.mark.manual("ARP-112")
def test_armed_inside_it_is_off_until_the_axis_comes_from_the_set_value() -> None:
    assert outputs(armed(5_000, 15_000, at=10_000), (10_000, 11_000, 16_000, 4_000, 10_000)) == [0, 0, 0, 0, 1]


@pytest.mark.manual("ARP-112")
def test_a_cam_passed_as_a_whole_within_a_loop_does_not_show() -> None:
    assert outputs(armed(5_000, 5_010), (4_990, 5_020, 4_990)) == [0, 0, 0]


@pytest.mark.manual("ARP-112")
def test_a_cam_drives_flags_and_inverted_outputs() -> None:
    card = SignalsCard()
    card.arm_cam_switch(1, CamSwitch(1, 10, 20, False, "F", 17))
    card.arm_cam_switch(6, CamSwitch(1, 10, 20, True, "F", 18))
    card.loop()
    assert (card.F[17], card.F[18], card.O[101]) == (0, 1, 0)
    card.positions[1] = 15
    card.loop()
    assert (card.F[17], card.F[18], card.O[101]) == (1, 0, 0)


@pytest.mark.manual("ARP-112")
@pytest.mark.manual("ARP-120")
def test_a_cam_is_written_in_every_loop_until_it_is_disarmed() -> None:
    bench = SignalsBench("CAM1 1, 10, 20, O101\nWAIT 0.005\nRES O101\nWAIT 0.005\nCAM1\nRES O101").run(2)
    bench.card.positions[1] = 15 * UNIT
    seen = [bench.run().card.O[101] for _ in range(12)]  # after the program's slice
    assert seen == [1, 1, 1, 0, 1, 1, 1, 1, 0, 0, 0, 0]


@pytest.mark.manual("ARP-112")
def test_disarming_leaves_the_output_as_it_is() -> None:
    card = armed(10, 20)
    assert outputs(card, (15,)) == [1]
    card.disarm_cam_switch(3)
    card.disarm_cam_switch(4)  # it was not armed
    assert outputs(card, (25, 5, 15)) == [1, 1, 1]
    card.cam_switches.reset()
    card.O[102] = 0
    assert outputs(card, (25, 5, 15)) == [0, 0, 0]


@pytest.mark.manual("ARP-112")
def test_the_instruction_with_other_values_replaces_the_cam_at_once() -> None:
    card = armed(10, 20)
    assert outputs(card, (15,)) == [1]
    card.arm_cam_switch(3, CamSwitch(2, 10 * UNIT, 20 * UNIT, False, "O", 102))  # the same again
    assert outputs(card, (16,)) == [1]
    card.arm_cam_switch(3, CamSwitch(2, 10 * UNIT, 30 * UNIT, False, "O", 102))
    assert outputs(card, (17, 25, 5, 25)) == [0, 0, 0, 1]


# ---- the wrap of a cyclic counter, 0 to 20000


def wrapped(positions: Iterable[float]) -> list[float]:
    return [position % TURN for position in positions]


@pytest.mark.manual("ARP-112")
def test_a_cam_that_begins_at_the_wrap_comes_on_in_every_turn() -> None:
    card = armed(0, 5_000, at=19_000, turn=TURN)
    assert outputs(card, wrapped((19_990, 20_010, 24_000, 25_500, 39_990, 40_010))) == [0, 1, 1, 0, 0, 1]
    card = armed(20_000, 15_000, at=1_000, turn=TURN)
    assert outputs(card, wrapped((10, -10, -4_000, -5_500, -19_990, -20_010))) == [0, 1, 1, 0, 0, 1]


@pytest.mark.manual("ARP-112")
def test_a_cam_that_ends_at_the_wrap_goes_off_there() -> None:
    assert outputs(armed(15_000, 20_000, 14_000, TURN), wrapped((16_000, 19_990, 20_010))) == [1, 1, 0]
    assert outputs(armed(5_000, 0, 6_000, TURN), wrapped((4_000, 10, -10))) == [1, 1, 0]


@pytest.mark.manual("ARP-112")
def test_passing_the_wrap_does_not_switch_a_cam_of_the_other_direction() -> None:
    assert outputs(armed(5_000, 15_000, 4_000, TURN), wrapped((100, -4_900, -5_100, -9_000))) == [0, 0, 0, 0]
    assert outputs(armed(15_000, 5_000, 16_000, TURN), wrapped((19_000, 24_900, 25_100, 29_000))) == [0, 0, 0, 0]


@pytest.mark.manual("ARP-112")
@pytest.mark.parametrize(("set_at", "reset_at"), [(19_000, 21_000), (-1_000, 1_000)])
def test_a_cam_may_reach_over_the_wrap(set_at: int, reset_at: int) -> None:
    card = armed(set_at, reset_at, at=18_000, turn=TURN)
    assert outputs(card, wrapped((19_500, 20_500, 21_500, 38_500, 40_500, 41_001))) == [1, 1, 0, 0, 1, 0]


@pytest.mark.manual("ARP-112")
def test_with_the_other_reading_the_wrap_is_a_jump() -> None:
    card = armed(0, 5_000, at=19_000, turn=TURN, wrap="jump")
    assert outputs(card, wrapped((19_990, 20_010, 24_000))) == [0, 0, 0]  # as if from above: over the reset value
    card = armed(19_000, 21_000, at=18_000, turn=TURN, wrap="jump")
    assert outputs(card, wrapped((19_500, 20_500))) == [1, 0]


@pytest.mark.manual("ARP-112")
def test_limits_of_the_counter_that_leave_no_turn_are_no_turn() -> None:
    for turn in (0, -50):  # the maximum is not above the minimum
        assert outputs(armed(10, 20, turn=turn), (15, 25)) == [1, 0]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(st.integers(0, 99), st.integers(1, 99), st.booleans(), st.lists(st.integers(-49, 49), max_size=30))
def test_a_fast_axis_switches_as_one_that_is_looked_at_everywhere(
    low: int, width: int, is_upward: bool, moves: list[int]
) -> None:
    """Cam switches anywhere on a turn of 100 units; the oracle checks them unit by unit."""
    ends = (low, low + width) if is_upward else (low + width, low)
    card = armed(*ends, at=0, turn=100)
    at, latched = 0, False
    for move in moves:
        for _ in range(abs(move)):
            came_from, at = at, at + (1 if move > 0 else -1)
            if not is_between(at, low, width):
                latched = False
            elif not is_between(came_from, low, width):
                latched = (move > 0) == is_upward
        assert outputs(card, (at % 100,)) == [latched]


def is_between(at: int, low: int, width: int) -> bool:
    return any(low + 100 * turn < at < low + width + 100 * turn for turn in range(at // 100 - 2, at // 100 + 2))
