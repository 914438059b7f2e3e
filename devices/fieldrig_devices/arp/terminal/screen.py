"""The screen: 8 lines of 16 columns, 128 x 64 pixels, and the messages on it.

Source: manual 5.12 (TERM); digest chapter 16.  Each message is at the place of its first character, regardless of its
height.  Another message at the same place replaces it, and covers older messages.  Erasing a place shows what was
covered.  Text beyond the edge of the screen is cut off.

In text form, a tall character is its letter in the first of its cells and blanks in the others.
"""

from dataclasses import dataclass
from typing import Final, Literal, NamedTuple

from fieldrig_devices.arp.terminal.pattern import Decimals, Pattern, find

LINES: Final = 8
COLUMNS: Final = 16
CELLS: Final = {1: 1, 2: 2, 3: 4}
"""Width and height of a character in cells of 8 x 8 pixels, by its height code: 8, 16 and 32 pixels."""

Edit = Literal["", "E", "P"]


class Place(NamedTuple):
    """Line and column, from 1.  It may be off the screen."""

    line: int
    column: int


@dataclass(slots=True)
class Text:
    """A message on the screen.

    A field that takes no value is shown as its pattern; a field that waits for its value is blank.
    """

    message: str
    height: int = 1
    has_value: bool = False
    edit: Edit = ""
    value: int | None = None
    typed: str | None = None
    """Text that the operator has typed so far, shown instead of the value."""

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
        """Texts by place; a text that covers others comes later."""

    def show(self, place: Place, text: Text) -> None:
        self.texts.pop(place, None)
        self.texts[place] = text

    def erase(self, place: Place) -> None:
        self.texts.pop(place, None)

    def clear(self) -> None:
        self.texts.clear()

    def set_value(self, place: Place, raw: int) -> None:
        """Set the value of the text at a place; without such a text, the value is dropped."""
        text = self.texts.get(place)
        if text is not None and text.has_value:
            text.value = raw

    def lines(self) -> list[str]:
        """The screen as eight texts of 16 characters."""
        grid = [[" "] * COLUMNS for _ in range(LINES)]
        for place, text in self.texts.items():
            size = CELLS[text.height]
            for number, character in enumerate(text.shown(self._decimals)):
                _draw(grid, place.line - 1, place.column - 1 + number * size, size, character)
        return ["".join(row) for row in grid]

    def described(self) -> list[str]:
        """A description of each text with its line, column and height, even if it is off the screen."""
        return [
            f"{place.line} {place.column} {text.height} {text.shown(self._decimals)}"
            for place, text in self.texts.items()
        ]

    def editable(self) -> list[Place]:
        """Places whose field the operator can see and change, in reading order."""
        return sorted(place for place, text in self.texts.items() if text.edit and self.field_cell(place) is not None)

    def field_cell(self, place: Place) -> Place | None:
        """Cell of the last visible character of a text's field, or None if none is visible."""
        text = self.texts[place]
        field, size = text.field, CELLS[text.height]
        if field is None or not 1 - size < place.line <= LINES:
            return None
        first = place.column + field.start * size
        columns = [column for column in range(first, first + field.width * size, size) if 1 - size < column <= COLUMNS]
        return Place(max(place.line, 1), max(columns[-1], 1)) if columns else None


def _draw(grid: list[list[str]], top: int, left: int, size: int, character: str) -> None:
    """Draw a character; `top` and `left` count from 0."""
    for row in range(max(top, 0), min(top + size, LINES)):
        for column in range(max(left, 0), min(left + size, COLUMNS)):
            is_first = row == max(top, 0) and column == max(left, 0)
            grid[row][column] = character if is_first else " "
