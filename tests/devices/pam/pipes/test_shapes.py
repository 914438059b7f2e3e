"""Shapes of cams: cubic splines through the points of a file."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pam.pipes.cam import Cam, Profile
from fieldrig_devices.pam.pipes.shapes import shape_of

STEP = 1e-4


def lines(*points: tuple[float, float]) -> bytes:
    return "\n".join(f"{x!r} {y!r}" for x, y in points).encode()


def bend(shape: object, x: float) -> float:
    """The second derivative, by differences."""
    assert callable(shape)
    return float((shape(x + STEP) - 2 * shape(x) + shape(x - STEP)) / STEP**2)


def slope(shape: object, x: float) -> float:
    assert callable(shape)
    return float((shape(x + STEP) - shape(x - STEP)) / (2 * STEP))


HUMP = [(0.0, 0.0), (0.2, 0.5), (0.5, 1.0), (0.7, 0.4), (1.0, 0.0)]
PERIOD = [(0.0, 0.0), (0.3, 0.2), (0.6, 0.8), (1.0, 1.0)]


@pytest.mark.manual("PAML-441")
@pytest.mark.manual("PAML-442")
@pytest.mark.parametrize("points", [HUMP, PERIOD])
def test_the_curve_passes_all_points_without_a_step_of_its_second_derivative(points: list[tuple[float, float]]) -> None:
    shape = shape_of(lines(*points))
    assert [shape(x) for x, _ in points] == pytest.approx([y for _, y in points])
    for x, _ in points[1:-1]:
        third = abs(bend(shape, x + 3 * STEP) - bend(shape, x - 3 * STEP)) / (6 * STEP)
        assert third < 200  # a step of the second derivative would give thousands


@pytest.mark.manual("PAML-448")
def test_many_points_need_more_digits_than_few() -> None:
    def roughest(count: int, digits: int) -> float:
        xs = [number / count for number in range(count + 1)]
        shape = shape_of(lines(*((x, round(x - math.sin(2 * math.pi * x) / (2 * math.pi), digits)) for x in xs)))
        return max(abs(bend(shape, x)) for x in xs[1:-1])

    smooth = 2 * math.pi  # the largest second derivative of this curve
    assert roughest(10, 3) == pytest.approx(smooth, rel=0.2)
    assert roughest(200, 3) > 5 * smooth
    assert roughest(200, 7) == pytest.approx(smooth, rel=0.2)


@pytest.mark.manual("PAML-447")
def test_a_shape_that_ends_where_it_begins_is_natural() -> None:
    shape = shape_of(lines(*HUMP))
    assert [bend(shape, x) for x in (2 * STEP, 1 - 2 * STEP)] == pytest.approx([0, 0], abs=0.1)


@pytest.mark.manual("PAML-447")
def test_a_shape_that_ends_a_period_higher_goes_on_smoothly() -> None:
    shape = shape_of(lines(*PERIOD))
    assert slope(shape, 2 * STEP) == pytest.approx(slope(shape, 1 - 2 * STEP), abs=0.01)
    assert bend(shape, 2 * STEP) == pytest.approx(bend(shape, 1 - 2 * STEP), abs=0.05)
    assert abs(bend(shape, 2 * STEP)) > 0.1  # which a natural one would not have


@pytest.mark.manual("PAML-442")
@given(st.integers(4, 40))
def test_points_of_a_sine_give_a_sine(count: int) -> None:
    """A periodic spline of a smooth curve has an error of the fourth order."""
    points = [(k / count, k / count + 0.1 * math.sin(2 * math.pi * k / count)) for k in range(count + 1)]
    shape = shape_of(lines(*points))
    for k in range(101):
        x = k / 100
        assert shape(x) == pytest.approx(x + 0.1 * math.sin(2 * math.pi * x), abs=0.4 * (2 * math.pi / count) ** 4 / 16)


@pytest.mark.manual("PAML-440")
def test_a_straight_line_is_straight_and_ends_hold() -> None:
    cam = Cam(Profile(shape_of(b"# feed\n0; 0\n0.25; 0.25\n1; 1\n"), 360, 100, 0, 10), None)
    cam.start(0.001)
    assert [cam.pass_on(x) for x in (-5, 0, 90, 360, 400)] == pytest.approx([10, 10, 35, 110, 110])


@pytest.mark.parametrize("data", [b"", b"0 0", b"0 0\n0 1", b"0 zero\n1 1", b"0 0\n1 nan", b"\xff\xfe", b"0 0 0\n1 1"])
def test_wrong_files_are_refused(data: bytes) -> None:
    with pytest.raises(ValueError, match="expected"):
        shape_of(data)


@given(st.binary(max_size=60))
def test_no_bytes_do_more_than_refuse(data: bytes) -> None:
    try:
        shape = shape_of(data)
    except ValueError:
        return
    assert isinstance(shape(0.5), float)


@pytest.mark.parametrize("end", ["\x1a", "\r\n\x1a\x1a", "\r\n\0\0", "\n\x1a; END\n7 7 7"])
def test_a_file_ends_as_dos_ends_it(end: str) -> None:
    assert shape_of(f"0 0\r\n1 1{end}".encode())(0.25) == pytest.approx(0.25)
