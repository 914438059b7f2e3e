"""User units and increments (CiA 402-2, factor group), and positions of 32 bits."""

from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.cia402.units import units_of, unwrapped, wrapped

COUNTS = st.tuples(st.integers(1, 2**32 - 1), st.integers(1, 10_000))


def test_a_gear_and_a_pitch() -> None:
    """10 turns of the motor are one of the spindle, which moves 5 mm in 0.001 mm."""
    units = units_of((1_000_000, 1), (10, 1), (5_000, 1), 0, origin=7.0)
    assert (units.increments(5_000), units.position(10_000_007.0)) == (10_000_007.0, 5_000)
    assert (units.speed(1_000), units.velocity(2_000_000.0)) == (2_000_000.0, 1_000)


def test_zeros_count_as_ones() -> None:
    assert units_of((0, 0), (0, 0), (0, 0), 0, 0.0).per_unit == 1.0


def test_the_ends_of_32_bits() -> None:
    assert (wrapped(0x8000_0000), wrapped(-0x8000_0001)) == (-0x8000_0000, 0x7FFF_FFFF)
    assert unwrapped(-0x8000_0000, near=0x8000_0100) == 0x8000_0000
    assert unwrapped(5, near=-3) == 5


@settings(deadline=None, max_examples=200)
@given(st.integers(-(2**60), 2**60), st.integers(-(2**31), 2**31 - 1))
def test_a_position_is_found_on_its_turn(near: int, shown: int) -> None:
    found = unwrapped(shown, near)
    assert wrapped(found) == shown
    assert abs(found - near) < 2**32


@settings(deadline=None, max_examples=200)
@given(COUNTS, COUNTS, COUNTS, st.integers(0, 255), st.integers(-(2**31), 2**31 - 1))
def test_there_and_back(
    encoder: tuple[int, int], gear: tuple[int, int], feed: tuple[int, int], polarity: int, position: int
) -> None:
    units = units_of(encoder, gear, feed, polarity, origin=0.0)
    assert abs(units.position(units.increments(position)) - position) <= 1
