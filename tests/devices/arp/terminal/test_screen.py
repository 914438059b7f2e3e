"""The screen: heights, places, text beyond the edge, erasing."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.terminal.screen import COLUMNS, LINES, Place, Screen, Text

pytestmark = pytest.mark.manual("ARP-115")

EMPTY = [""] * 8


def lines(screen: Screen) -> list[str]:
    return [line.rstrip() for line in screen.lines()]


def screen_with(*texts: tuple[int, int, int, str]) -> Screen:
    screen = Screen()
    for line, column, height, text in texts:
        screen.show(Place(line, column), Text(text, height))
    return screen


def test_screen_has_8_lines_of_16_columns() -> None:
    assert [len(line) for line in Screen().lines()] == [16] * 8


# Height, and the lines that "AB" at line 2, column 3 fills; a letter is in the first of its cells.
HEIGHTS = [
    (1, ["", "  AB", "", "", "", ""]),
    (2, ["", "  A B", "", "", "", ""]),
    (3, ["", "  A   B", "", "", "", ""]),
]


@pytest.mark.parametrize(("height", "shown"), HEIGHTS)
def test_letter_of_each_height(height: int, shown: list[str]) -> None:
    assert lines(screen_with((2, 3, height, "AB")))[:6] == shown


@pytest.mark.parametrize(("height", "cells"), [(1, 1), (2, 2), (3, 4)])
def test_letter_covers_8_16_or_32_pixels(height: int, cells: int) -> None:
    under = [(line, 1, 1, "." * 16) for line in range(1, 9)]
    shown = screen_with(*under, (3, 5, height, "X")).lines()
    covered = {(row, column) for row in range(LINES) for column in range(COLUMNS) if shown[row][column] != "."}
    assert covered == {(row, column) for row in range(2, 2 + cells) for column in range(4, 4 + cells)}


# Text beyond the edge of the screen is cut off; place and text.
CUT = [
    ((1, 10, 1, "AUTOMATIC CYCLE"), ["         AUTOMAT"]),
    ((1, 16, 1, "AB"), ["               A"]),
    ((1, 17, 1, "AB"), [""]),
    ((1, 0, 1, "AB"), ["B"]),
    ((8, 1, 3, "AB"), ["", "", "", "", "", "", "", "A   B"]),
    ((9, 1, 1, "AB"), [""]),
    ((0, 1, 2, "AB"), ["A B"]),  # its lower half
    ((0, 1, 1, "AB"), [""]),
    ((2, 22, 3, "LENGTH"), [""]),
    ((1, 2, 2, "LENGTH: = 12.345"), [" L E N G T H :"]),
]


@pytest.mark.parametrize(("text", "shown"), CUT)
def test_text_beyond_the_screen_is_cut(text: tuple[int, int, int, str], shown: list[str]) -> None:
    assert lines(screen_with(text)) == (shown + EMPTY)[:8]


def test_text_at_the_same_place_takes_its_place() -> None:
    assert lines(screen_with((1, 1, 1, "LONG TEXT"), (1, 1, 1, "OK")))[0] == "OK"


def test_later_text_lies_over_the_earlier_and_erasing_it_brings_that_back() -> None:
    screen = screen_with((1, 1, 1, "ABCDEF"), (1, 3, 1, "xy"))
    assert lines(screen)[0] == "ABxyEF"
    screen.erase(Place(1, 3))
    assert lines(screen)[0] == "ABCDEF"
    screen.erase(Place(1, 2))  # no message begins there
    assert lines(screen)[0] == "ABCDEF"


def test_text_that_is_shown_again_comes_to_the_top() -> None:
    screen = screen_with((1, 1, 1, "ABCDEF"), (1, 3, 1, "xy"), (1, 1, 1, "abcd"))
    assert lines(screen)[0] == "abcd"


def test_clear_leaves_nothing() -> None:
    screen = screen_with((1, 1, 1, "ABC"), (4, 4, 3, "X"))
    screen.clear()
    assert lines(screen) == EMPTY


def test_field_shows_pattern_blank_or_value() -> None:
    screen = screen_with((1, 1, 1, "L ##.#"))
    assert lines(screen)[0] == "L ##.#"  # TERM without a variable
    screen.show(Place(1, 1), Text("L ##.# mm", has_value=True))
    assert screen.lines()[0][:9] == "L      mm"  # its value has not arrived yet
    screen.set_value(Place(1, 1), 12_340)
    assert lines(screen)[0] == "L 12.3 mm"


def test_value_for_a_place_without_a_field_is_dropped() -> None:
    screen = screen_with((1, 1, 1, "L ##.#"))
    screen.set_value(Place(1, 1), 5_000)
    screen.set_value(Place(2, 2), 5_000)
    assert lines(screen) == ["L ##.#", *EMPTY[1:]]


TEXTS = st.tuples(st.integers(0, 255), st.integers(0, 255), st.integers(1, 3), st.text("AB #.", max_size=16))
NEAR = st.tuples(st.integers(0, 9), st.integers(0, 18), st.integers(1, 3), st.text("AB #.", max_size=16))


@pytest.mark.long
@given(st.lists(TEXTS | NEAR, max_size=8))
@settings(max_examples=100, deadline=None)
def test_screen_keeps_its_size_and_is_empty_again_when_all_is_erased(texts: list[tuple[int, int, int, str]]) -> None:
    screen = screen_with(*texts)
    assert [len(line) for line in screen.lines()] == [16] * 8
    for line, column, _, _ in texts:
        screen.erase(Place(line, column))
    assert lines(screen) == EMPTY
