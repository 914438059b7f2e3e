"""Reading a point gives its value, or names the mistake of the class of a device."""

from math import inf, nan
from typing import Any

import pytest

from fieldrig.device import Point
from fieldrig.errors import ControlError
from fieldrig.points.access import read_point, read_points


def failing() -> float:
    raise ValueError("no sensor")


@pytest.mark.parametrize("value", [nan, inf, -(2**63), 2**64 - 1, "", True])
def test_a_value_is_read_as_it_is(value: Any) -> None:
    assert read_point("press", {"state": Point(lambda: value)}, "state") is value


@pytest.mark.parametrize("value", [None, b"\x00", [1, 2], (1.0,), 1j])
def test_a_value_of_another_type_is_refused_by_its_name(value: Any) -> None:
    """Its answer was no JSON: reading it ended the process of the device."""
    with pytest.raises(ControlError, match="press/state cannot be read: it is "):
        read_points("press", {"other": Point(lambda: 1), "state": Point(lambda: value)})


@pytest.mark.parametrize("value", [2**64, -(2**63) - 1])
def test_a_whole_number_has_at_most_64_bits(value: int) -> None:
    with pytest.raises(ControlError, match=r"press/state cannot be read: it has 6[45] bits"):
        read_point("press", {"state": Point(lambda: value)}, "state")


def test_a_point_that_fails_is_named() -> None:
    """It was `not understood: no sensor`, with neither device nor key."""
    with pytest.raises(ControlError, match="press/state cannot be read: no sensor"):
        read_points("press", {"other": Point(lambda: 1), "state": Point(failing)})
