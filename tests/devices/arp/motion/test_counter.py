"""Conversion of encoder counts to the position counter: manual 3.2, @ParX[1] to [6], and the passing flags of 4.6."""

import pytest
from arp_axes import AxesBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.language.instructions import WRITABLE
from fieldrig_devices.arp.motion.counter import Counter, Span
from fieldrig_devices.arp.motion.flags import AxisFlag, AxisFlags


@pytest.mark.manual("ARP-018")
def test_counts_become_units_as_in_the_example_of_the_manual() -> None:
    """A22: 2000 pulses, a leadscrew of 10 mm after a gear of 1/12, counted in 0.01 mm."""
    bench = AxesBench((1, 1, 2000 * 4 / (1000 / 12)))
    assert bench.parameters.ram[1][1] == 96_000
    bench.counts[1] = 12 * 8000  # one turn of the leadscrew
    bench.loop()
    assert bench.axes.position(1) == 1_000_000


@pytest.mark.manual("ARP-021")
@pytest.mark.parametrize(("signs", "reading"), [(0, 250.0), (1, -250.0), (2, 250.0), (3, -250.0)])
def test_bit_0_of_the_sign_mode_reverses_the_encoder(signs: int, reading: float) -> None:
    bench = AxesBench((2, 1, 4.0), (2, 3, signs))
    bench.counts[2] = 1000
    assert bench.loop().reading(2) == reading


def test_axis_without_a_wire_reads_0_and_finds_its_encoder_without_having_moved() -> None:
    bench = AxesBench((1, 5, 360.0), (1, 6, 0.0))
    assert bench.loop(3).axes.position(1) == 0
    bench.counts[1] = 1000
    bench.loop()
    assert bench.axes.position(1) == 280_000
    assert bench.axes.speed(1) == 0
    assert not bench.F[267]
    assert bench.axes.diagnostic(1, 1) == 1000


@pytest.mark.manual("ARP-023", "ARP-073", "ARP-065")
@pytest.mark.parametrize(("axis", "up", "down"), [(1, 267, 268), (2, 299, 300)])
def test_counter_goes_round_and_says_which_way(axis: int, up: int, down: int) -> None:
    bench = AxesBench((axis, 5, 360.0), (axis, 6, 0.0))
    bench.counts[axis] = 350
    bench.loop()
    bench.counts[axis] = 360
    bench.loop()
    assert bench.axes.position(axis) == 360_000  # the maximum itself is a position
    assert (bench.F[up], bench.F[down]) == (0, 0)
    bench.counts[axis] = 365
    bench.loop()
    assert bench.axes.position(axis) == 5_000
    assert (bench.F[up], bench.F[down]) == (1, 0)
    bench.loop()
    assert bench.F[up] == 1  # until the program clears it
    bench.F[up] = 0
    bench.counts[axis] = 355
    bench.loop()
    assert bench.axes.position(axis) == 355_000
    assert (bench.F[up], bench.F[down]) == (0, 1)


# Manual 4.6, table 1: axis 1, axis 2, and whether a program may write it.
SYSTEM_FLAGS = [
    (257, 289, "R", None),
    (258, 290, "R", AxisFlag.HOMING),
    (259, 291, "R", AxisFlag.HOMED),
    (260, 292, "R", AxisFlag.ARRIVED),
    (261, 293, "R", AxisFlag.SYNCHRONOUS),
    (262, 294, "R/W", AxisFlag.STOP),
    (263, 295, "R", AxisFlag.RUNNING),
    (264, 296, "R", AxisFlag.FINAL_SPEED),
    (265, 297, "R/W", AxisFlag.ARM_RISING),
    (266, 298, "R/W", AxisFlag.ARM_FALLING),
    (267, 299, "R/W", AxisFlag.PASSED_MAXIMUM),
    (268, 300, "R/W", AxisFlag.PASSED_MINIMUM),
]


@pytest.mark.manual("ARP-065")
@pytest.mark.parametrize(("first", "second", "access", "flag"), SYSTEM_FLAGS)
def test_system_flags_lie_where_the_manual_has_them(
    first: int, second: int, access: str, flag: AxisFlag | None
) -> None:
    for axis, number in ((1, first), (2, second)):
        assert (number in WRITABLE) is (access == "R/W")
        if flag is not None:
            flags = [0] * 321
            AxisFlags(axis, flags)[flag] = 1
            assert [place for place, bit in enumerate(flags) if bit] == [number]


@pytest.mark.manual("ARP-065")
@pytest.mark.parametrize("axis", [1, 2])
def test_a_movement_shows_in_the_flags_of_its_axis_alone(axis: int) -> None:
    first = {1: 257, 2: 289}[axis]
    kinds = (axis, 4, 1.0)  # simulated
    bench = AxesBench(kinds, (axis, 7, 100.0), (axis, 8, 1_000.0))
    others = [number for number in range(257, 321) if not first <= number < first + 32]
    before = [bench.F[number] for number in others]
    bench.loop(50)
    bench.axes.move_to(axis, 10_000)
    bench.loop()
    assert (bench.F[first + 3], bench.F[first + 6]) == (0, 1)  # F260 arrived, F263 movement
    bench.loop(1_000)
    assert (bench.F[first + 3], bench.F[first + 6]) == (1, 0)
    bench.axes.move_to(axis, 90_000)
    bench.loop(300)
    bench.F[first + 5] = 1  # F262: stop, at its speed
    bench.loop(5)
    assert (bench.F[first + 3], bench.F[first + 6], bench.F[first + 7]) == (0, 0, 1)  # F264 final speed
    assert [bench.F[number] for number in others] == before


@pytest.mark.manual("ARP-023")
def test_default_limits_are_the_extremes() -> None:
    bench = AxesBench()
    bench.counts[1] = 0
    bench.loop()
    bench.counts[1] = 999_999
    assert bench.loop().axes.position(1) == 999_999_000
    assert not bench.F[267]


@pytest.mark.manual("ARP-073")
def test_jump_over_several_ranges_lands_inside() -> None:
    bench = AxesBench((1, 5, 180.0), (1, 6, -180.0))
    bench.counts[1] = 0
    bench.loop()
    bench.counts[1] = 5 * 360 + 7
    assert bench.loop().reading(1) == 7.0
    assert bench.F[267] == 1
    bench.counts[1] = -4 * 360 - 7
    assert bench.loop().reading(1) == -7.0
    assert bench.F[268] == 1


@pytest.mark.manual("ARP-073")
def test_simulated_axis_passes_too() -> None:
    bench = AxesBench((1, 4, 1), (1, 5, 360.0), (1, 6, 0.0))
    bench.axes.move_by(1, -10_000)
    bench.until_flag(1, AxisFlag.RUNNING, 0)
    assert bench.axes.position(1) == 350_000
    assert (bench.F[267], bench.F[268]) == (0, 1)


def test_limits_in_the_wrong_order_let_nothing_go_round() -> None:
    bench = AxesBench((1, 5, 0.0), (1, 6, 100.0))
    bench.counts[1] = 0
    bench.loop()
    bench.counts[1] = 5000
    assert bench.loop().reading(1) == 5000.0


@pytest.mark.parametrize(("low", "high"), [(5, 5), (5, 4)])
def test_limits_without_a_range_between_them_wrap_nothing(low: float, high: float) -> None:
    span = Span(low, high)
    assert [span.wrapped(value) for value in (-7.0, 5.0, 1e6)] == [-7.0, 5.0, 1e6]


def test_encoder_counter_has_32_bits() -> None:
    counter = Counter(Span(-1e6, 1e6), 1.0)
    counter.take(10**400)
    assert abs(counter.delta) < 1 << 31
    assert -1e6 <= counter.reading <= 1e6


@pytest.mark.parametrize("kind", [0, 1, 2])
def test_any_number_on_the_wire_is_taken(kind: int) -> None:
    bench = AxesBench((1, 4, kind))
    for counts in (10**400, -(10**400), 0, 1 << 31, -(1 << 31) - 1):
        bench.counts[1] = counts
        bench.loop()
        assert abs(bench.axes.position(1)) <= 999_999_999
        assert abs(bench.axes.diagnostic(1, 1)) <= 1 << 31


def test_new_resolution_and_new_limits_keep_the_reading() -> None:
    bench = AxesBench((1, 1, 2.0))
    bench.counts[1] = 1000
    assert bench.loop().reading(1) == 500.0
    bench.set(1, 1, 10.0)
    assert bench.loop().reading(1) == 500.0
    bench.counts[1] = 1100
    assert bench.loop().reading(1) == 510.0
    bench.set(1, 5, 360.0)
    bench.set(1, 6, 0.0)
    assert bench.loop().reading(1) == 150.0


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(
    st.floats(-1e5, 1e5),
    st.floats(0.01, 1e5),
    st.sampled_from([1.0, -1 / 96, 1 / 3, 1000.0]),
    st.lists(st.integers(-(1 << 31), (1 << 31) - 1), max_size=30),
)
def test_reading_stays_in_its_range_whatever_the_encoder_does(
    low: float, length: float, per_count: float, jumps: list[int]
) -> None:
    counter = Counter(Span(low, low + length), per_count)
    counter.preset(counter.span.wrapped(0.0))
    at = 0
    for jump in jumps:
        at += jump
        before = counter.reading
        laps = counter.take(at)
        assert counter.span.low <= counter.reading <= counter.span.high
        travel = laps * counter.span.length + counter.reading - before
        assert travel == pytest.approx(counter.delta * per_count, rel=1e-6, abs=1e-3)
