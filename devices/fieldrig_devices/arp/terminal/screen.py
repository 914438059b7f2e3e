"""The screen: 8 lines of 16 columns, 128 x 64 pixels, and the messages that stand on it.

Source: manual 5.12 (TERM); digest chapter 16.  Each message stands at the place of its first character, whatever its
height; another one at the same place takes its place, and lies over those that were there before.  Erasing a place
brings back what lay under it.  What goes beyond the screen is cut off.

As text, a tall character is its letter in the first of its cells and blanks in the others.
"""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from fieldrig_devices.arp.terminal.pattern import Decimals, Pattern, find

LINES: Final = 8
COLUMNS: Final = 16
CELLS: Final = {1: 1, 2: 2, 3: 4}
"""Cells of 8 x 8 pixels that a character is wide and high, by height: 8, 16 and 32 pixels."""

Edit = Literal["", "E", "P"]


class Place(NamedTuple):
    """From 1; off the screen it may be too."""

    line: int
    column: int


@dataclass(slots=True)
class Text:
    """A message on the screen.  A field without a value stands as its pattern; one that waits for it is blank."""

    message: str
    height: int = 1
    has_value: bool = False
    edit: Edit = ""
    value: int | None = None
    typed: str | None = None
    """What the operator has typed so far, in place of the value."""

    @property
    def field(self) -> Pattern | None:
        return find(self.message) if self.has_value else None

    def shown(self, decimals: Decimals = "cut") -> str:
        field = self.field
        if field is None:
            return self.message
        if self.typed is not None:
            inside = self.typed.rjust(field.width)[-field.width :]
        else:
            inside = " " * field.width if self.value is None else field.show(self.value, decimals)
        return field.put_into(self.message, inside)


class Screen:
    def __init__(self, decimals: Decimals = "cut") -> None:
        self._decimals = decimals
        self.texts: dict[Place, Text] = {}
        """What lies over others comes later."""

    def show(self, place: Place, text: Text) -> None:
        self.texts.pop(place, None)
        self.texts[place] = text

    def erase(self, place: Place) -> None:
        self.texts.pop(place, None)

    def clear(self) -> None:
        self.texts.clear()

    def set_value(self, place: Place, raw: int) -> None:
        """What is not there takes no value."""
        text = self.texts.get(place)
        if text is not None and text.has_value:
            text.value = raw

    def lines(self) -> list[str]:
        """Eight texts of 16 characters: what each cell shows."""
        grid = [[" "] * COLUMNS for _ in range(LINES)]
        for place, text in self.texts.items():
            size = CELLS[text.height]
            for number, character in enumerate(text.shown(self._decimals)):
                _draw(grid, place.line - 1, place.column - 1 + number * size, size, character)
        return ["".join(row) for row in grid]

    def described(self) -> list[str]:
        """Each text with its line, column and height, however much of it is on the screen."""
        return [
            f"{place.line} {place.column} {text.height} {text.shown(self._decimals)}"
            for place, text in self.texts.items()
        ]

    def editable(self) -> list[Place]:
        """The places whose field the operator can see and change, in reading order."""
        return sorted(place for place, text in self.texts.items() if text.edit and self.field_cell(place) is not None)

    def field_cell(self, place: Place) -> Place | None:
        """The cell of the last character of its field that is on the screen; None if none is."""
        text = self.texts[place]
        field, size = text.field, CELLS[text.height]
        if field is None or not 1 - size < place.line <= LINES:
            return None
        first = place.column + field.start * size
        columns = [column for column in range(first, first + field.width * size, size) if 1 - size < column <= COLUMNS]
        return Place(max(place.line, 1), max(columns[-1], 1)) if columns else None


def _draw(grid: list[list[str]], top: int, left: int, size: int, character: str) -> None:
    """From 0."""
    for row in range(max(top, 0), min(top + size, LINES)):
        for column in range(max(left, 0), min(left + size, COLUMNS)):
            is_first = row == max(top, 0) and column == max(left, 0)
            grid[row][column] = character if is_first else " "
