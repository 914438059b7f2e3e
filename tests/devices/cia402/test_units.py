"""User units and increments (CiA 402-2, factor group), and positions of 32 bits."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.cia402.units import BITS_32, Direction, Turn, turn_of, units_of

COUNTS = st.tuples(st.integers(1, 2**32 - 1), st.integers(1, 10_000))


def test_a_gear_and_a_pitch() -> None:
    """10 turns of the motor are one of the spindle, which moves 5 mm in 0.001 mm."""
    units = units_of((1_000_000, 1), (10, 1), (5_000, 1), 0, origin=7.0)
    assert (units.increments(5_000), units.position(10_000_007.0)) == (10_000_007.0, 5_000)
    assert (units.speed(1_000), units.velocity(2_000_000.0)) == (2_000_000.0, 1_000)


def test_zeros_count_as_ones() -> None:
    assert units_of((0, 0), (0, 0), (0, 0), 0, 0.0).per_unit == 1.0


def test_the_ends_of_32_bits() -> None:
    assert (BITS_32.shown(0x8000_0000), BITS_32.shown(-0x8000_0001)) == (-0x8000_0000, 0x7FFF_FFFF)
    assert BITS_32.meant(-0x8000_0000, near=0x8000_0100) == 0x8000_0000
    assert BITS_32.meant(5, near=-3) == 5


# 607Bh from 0 to 359: the meaning of a target for an axis at 350 of its second revolution.
@pytest.mark.parametrize(
    ("direction", "shown", "meant"),
    [
        (Direction.AS_LINEAR, 10, 370),
        (Direction.NEGATIVE, 10, 370),
        (Direction.NEGATIVE, 355, 355),
        (Direction.NEGATIVE, 350, 710),
        (Direction.POSITIVE, 10, 730),
        (Direction.POSITIVE, 340, 1060),
        (Direction.POSITIVE, 350, 710),
        (Direction.SHORTEST, 10, 730),
        (Direction.SHORTEST, 340, 700),
        (Direction.SHORTEST, 170, 890),  # as far in both directions: the positive one
        (Direction.SHORTEST, 171, 531),
        (Direction.AS_LINEAR, 360, 360),  # begins again at 0
    ],
)
def test_ways_on_a_turn(direction: Direction, shown: int, meant: int) -> None:
    assert turn_of(0, 359).meant(shown, 710, direction) == meant


@pytest.mark.parametrize(("low", "high"), [(0, 0), (10, -10), (-0x8000_0000, 0x7FFF_FFFF)])
def test_no_range_is_that_of_32_bits(low: int, high: int) -> None:
    assert turn_of(low, high) == BITS_32


@pytest.mark.long
@settings(deadline=None, max_examples=200)
@given(
    st.integers(-(2**60), 2**60),
    st.integers(-(2**31), 2**31 - 1),
    st.integers(-(2**31), 2**31 - 1),
    st.integers(1, 2**32),
    st.sampled_from(Direction),
)
def test_a_position_is_found_less_than_a_turn_away(
    near: int, shown: int, low: int, span: int, direction: Direction
) -> None:
    turn = Turn(low, span)
    found = turn.meant(shown, near, direction)
    assert turn.shown(found) == turn.shown(shown)
    assert abs(found - near) < span


@pytest.mark.long
@settings(deadline=None, max_examples=200)
@given(COUNTS, COUNTS, COUNTS, st.integers(0, 255), st.integers(-(2**31), 2**31 - 1))
def test_there_and_back(
    encoder: tuple[int, int], gear: tuple[int, int], feed: tuple[int, int], polarity: int, position: int
) -> None:
    units = units_of(encoder, gear, feed, polarity, origin=0.0)
    assert abs(units.position(units.increments(position)) - position) <= 1
