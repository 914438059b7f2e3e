"""The curve of PST: manual 5.9.4.1; digest 13.2, 13.3 and 13.6.  Golden points are the digest's examples A and B."""

import math

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.motion.cam_table import CamTable, Demand, Point, TableError, read_points
from fieldrig_devices.arp.motion.counter import Span

WIDE = Span(-999_999.999, 999_999.999)
A = [Point(0, 0), Point(5000, 5000), Point(10_000, 0)]
B = [Point(0, 0), Point(1000, 500), Point(2000, 2000), Point(3000, 2000), Point(4000, 1000), Point(5000, 0)]
OF_A = Demand(5000.0, 1e6, 50_000.0)
OF_B = Demand(2000.0, 1e6, 20_000.0)


@pytest.mark.manual("ARP-102", "ARP-034")
@pytest.mark.parametrize(
    ("master", "slave"),
    [(0, 0), (2500, 2500), (4500, 4500), (4750, 4687.5), (5000, 4750), (5250, 4687.5), (5500, 4500), (10_000, 0)],
)
def test_example_a_point_by_point(master: float, slave: float) -> None:
    assert CamTable(A, WIDE, WIDE, OF_A).at(master).slave == slave


@pytest.mark.manual("ARP-102")
def test_widths_of_the_joins() -> None:
    assert CamTable(A, WIDE, WIDE, OF_A).joins == [0, 1000, 0]
    assert CamTable(B, WIDE, WIDE, OF_B).joins == [0, 200, 300, 200, 0, 0]


@pytest.mark.manual("ARP-101", "ARP-102")
@pytest.mark.parametrize(
    ("master", "slave"),
    [
        (900, 450), (1000, 525), (1100, 650), (1850, 1775), (2000, 1943.75), (2150, 2000), (2500, 2000),
        (2900, 2000), (3000, 1975), (3100, 1900), (4000, 1000), (5000, 0),
    ],
)  # fmt: skip
def test_example_b_point_by_point(master: float, slave: float) -> None:
    assert CamTable(B, WIDE, WIDE, OF_B).at(master).slave == pytest.approx(slave, abs=1e-12)


@pytest.mark.manual("ARP-102")
def test_slave_uses_its_acceleration_in_the_join_at_the_full_speed_of_the_master() -> None:
    value = CamTable(A, WIDE, WIDE, OF_A).at(5000)
    assert value.curvature * 5000**2 == -50_000
    assert value.slope == 0


@pytest.mark.manual("ARP-101")
def test_slave_rests_between_points_of_the_same_position() -> None:
    table = CamTable(B, WIDE, WIDE, OF_B)
    for master in range(2150, 2901, 10):
        assert table.at(master).slave == 2000
        assert table.at(master).slope == 0


@pytest.mark.manual("ARP-102")
def test_joins_that_pass_through_the_points() -> None:
    """The other interpretation of "passing by": the points are on the curve, and the acceleration is kept."""
    for points, demand in ((A, OF_A), (B, OF_B)):
        table = CamTable(points, WIDE, WIDE, demand, "through")
        for master, slave in points:
            assert table.at(master).slave == pytest.approx(slave, abs=1e-8)
            bend = abs(table.at(master).curvature) * demand.master_speed**2
            assert bend == pytest.approx(0, abs=1e-6) or bend == pytest.approx(demand.slave_acceleration)
    assert table.at(2500).slope == pytest.approx(-0.043, abs=5e-4)  # digest 13.2: the dwell disappears


def test_joins_through_points_that_leave_no_room_are_refused() -> None:
    """Rounded off, these joins just fit; to pass through the points, the corners would have to be sharper."""
    zigzag = [Point(100 * number, 100 * (number % 2)) for number in range(8)]
    demand = Demand(100.0, 1e9, 100.0**2 * 2 / 100)
    CamTable(zigzag, WIDE, WIDE, demand)
    with pytest.raises(TableError):
        CamTable(zigzag, WIDE, WIDE, demand, "through")


@pytest.mark.manual("ARP-104")
def test_kind_of_the_cam_follows_from_its_ends() -> None:
    turn, other = Span(0, 10_000), Span(0, 5000)
    rising = [Point(0, 0), Point(4000, 3000), Point(10_000, 5000)]
    falling = [Point(0, 5000), Point(4000, 3000), Point(10_000, 0)]
    cyclic = CamTable(rising, turn, other, OF_A)
    assert (cyclic.is_repetitive, cyclic.lap) == (True, 5000)
    backwards = CamTable(falling, turn, other, OF_A)
    assert (backwards.is_repetitive, backwards.lap) == (True, -5000)
    linear = CamTable(A, turn, WIDE, OF_A)
    assert (linear.is_repetitive, linear.lap) == (True, 0)
    assert not CamTable(rising, turn, WIDE, OF_A).is_repetitive
    assert not CamTable(A, Span(0, 10_001), WIDE, OF_A).is_repetitive


@pytest.mark.manual("ARP-104")
@pytest.mark.parametrize("join", ["round", "through"])
def test_repetitive_cam_joins_its_ends(join: str) -> None:
    table = CamTable(A, Span(0, 10_000), WIDE, OF_A, "through" if join == "through" else "round")
    assert table.joins == pytest.approx([1000 if join == "round" else 1127.017] * 3)
    left, right = table.at(10_000), table.at(0)
    assert left == pytest.approx(right)
    assert left.slope == pytest.approx(0, abs=1e-12)
    assert left.curvature * 5000**2 == pytest.approx(50_000)
    assert left.slave == pytest.approx(250 if join == "round" else 0, abs=1e-8)  # 2 * 1000 / 8


@pytest.mark.manual("ARP-104")
def test_cyclic_slave_goes_on_smoothly_over_the_end() -> None:
    points = [Point(0, 0), Point(4000, 1000), Point(10_000, 5000)]
    table = CamTable(points, Span(0, 10_000), Span(0, 5000), OF_A)
    left, right = table.at(10_000), table.at(0)
    assert left.slave - table.lap == pytest.approx(right.slave)
    assert left.slope == pytest.approx(right.slope)


@pytest.mark.manual("ARP-104")
def test_non_repetitive_cam_has_no_join_at_its_ends() -> None:
    table = CamTable(A, WIDE, WIDE, OF_A)
    assert table.at(0) == (0, 1, 0)
    assert table.at(10_000) == (0, -1, 0)


def raw(*values: float) -> list[int]:
    return [0, *(round(value * 1000) for value in values)] + [0] * 1000


@pytest.mark.manual("ARP-101")
def test_table_is_in_the_variables_as_pairs() -> None:
    """A17; the table of 22 pairs is 45 variables long (digest 21)."""
    flat = [value for point in B for value in point]
    assert read_points(raw(6, *flat), 1) == B
    longest = raw(*([0] * 955), 22, *(value for n in range(22) for value in (n, -n)))
    assert read_points(longest, 956)[-1] == (21, -21)


@pytest.mark.manual("ARP-103")
@pytest.mark.parametrize("pairs", [-1, 0, 1, 1.999, 23, 999_999])
def test_wrong_count_of_pairs(pairs: float) -> None:
    with pytest.raises(TableError, match="pairs"):
        read_points(raw(pairs, *range(60)), 1)


@pytest.mark.parametrize("first", [957, 1000, 1001, 0, -5])
def test_table_must_end_within_the_variables(first: int) -> None:
    variables = raw()
    if 1 <= first <= 1000:
        variables[first] = 22_000
    with pytest.raises(TableError):
        read_points(variables, first)


@pytest.mark.manual("ARP-103")
@pytest.mark.parametrize("masters", [(0, 0, 5), (0, 5, 5), (0, 6, 5), (5, 4, 3)])
def test_master_points_must_rise(masters: tuple[int, ...]) -> None:
    with pytest.raises(TableError, match="increase"):
        read_points(raw(3, *(value for master in masters for value in (master, 0))), 1)


@pytest.mark.manual("ARP-103")
def test_slave_may_not_exceed_its_speed() -> None:
    CamTable(A, WIDE, WIDE, Demand(5000.0, 5000.0, 50_000.0))
    with pytest.raises(TableError, match="speed"):
        CamTable(A, WIDE, WIDE, Demand(5000.0, 4999.999, 50_000.0))


@pytest.mark.manual("ARP-103", "ARP-034")
def test_join_may_be_as_wide_as_there_is_room() -> None:
    """Digest 13.6: example A fits up to 15811.388 master units per second."""
    CamTable(A, WIDE, WIDE, Demand(15_811.388, 1e6, 50_000.0))
    with pytest.raises(TableError, match="wider"):
        CamTable(A, WIDE, WIDE, Demand(15_811.389, 1e6, 50_000.0))
    with pytest.raises(TableError, match="wider"):  # repetitive: half a join at each end, so only half the distance
        CamTable(A, Span(0, 10_000), WIDE, Demand(15_811.388, 1e6, 50_000.0))


TABLES = st.lists(st.tuples(st.floats(10, 1000), st.floats(-1000, 1000)), min_size=2, max_size=22)


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(TABLES, st.floats(10, 1000), st.booleans(), st.sampled_from(["round", "through"]))
def test_curve_has_no_steps_in_position_or_slope(
    pairs: list[tuple[float, float]], speed: float, is_repetitive: bool, join: str
) -> None:
    points, master = [], 0.0
    for width, slave in pairs:
        points.append(Point(master, slave))
        master += width
    if is_repetitive:
        points[-1] = Point(points[-1].master, points[0].slave)
    span = Span(points[0].master, points[-1].master) if is_repetitive else WIDE
    demand = Demand(speed, math.inf, speed * speed * 5)
    try:
        table = CamTable(points, span, WIDE, demand, "through" if join == "through" else "round")
    except TableError:
        assume(False)
    grain = (table.high - table.low) / 500
    for number in range(500):
        here, there = table.at(table.low + number * grain), table.at(table.low + (number + 1) * grain)
        assert abs(there.slope - here.slope) <= 5 * grain * (1 + 1e-6)  # AccS / VelM^2
        middle = (here.slope + there.slope) / 2
        assert there.slave - here.slave == pytest.approx(middle * grain, abs=2.5 * grain * grain + 1e-6)
    if is_repetitive:
        assert table.at(table.low)[:2] == pytest.approx(table.at(table.high)[:2], abs=1e-6)
