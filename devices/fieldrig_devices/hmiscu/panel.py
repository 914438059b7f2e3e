"""The panel side: keys, lamps and the lines of the display, for programs, masters and tools.

Source: ours, as the library manual describes the controller only; the panel is a touch screen, so its keys and lamps
are fields on it.  Keys are bits 0 to 7 of %IW8, lamps those of %QW8, and the function PanelText writes a line.
"""

from collections.abc import Iterator
from functools import partial
from typing import Final

from fieldrig.device import Point, Value
from fieldrig.points.checks import text_in, truth_in
from fieldrig_devices.iec.host import Library, NativeFunction, Results

KEYS: Final = 8
LAMPS: Final = 8
LINES: Final = 8
WIDTH: Final = 40
"""Characters in a line."""
AREA_BYTE: Final = 16
"""The byte of keys in %I, and of lamps in %Q."""
RECENT: Final = 20
"""Cycles of MAST for which a line counts as written by the program: slower tasks write lines too."""
TEXT: Final = f"""
FUNCTION PanelText : BOOL
VAR_INPUT
  Line : INT; (* 1 to {LINES} *)
  Text : STRING({WIDTH});
END_VAR
{{native}}
END_FUNCTION
"""


class Panel:
    """The state of the panel."""

    def __init__(self, outputs: bytearray) -> None:
        """`outputs` is the area %Q, in which masters and tools switch lamps as programs do."""
        self._outputs = outputs
        self.keys = [False] * KEYS
        self.lamps = [False] * LAMPS
        self.lines = [""] * LINES
        self._cycles = 0
        self._written: dict[str, int] = {}
        """The cycle in which the program wrote a line last, by the name of its point."""

    def is_written(self, name: str) -> bool:
        """Return whether the program keeps writing this line, so that another text would be gone at once."""
        return self._cycles - self._written.get(name.casefold(), -RECENT) < RECENT

    def library(self) -> Library:
        return Library("HMISCU_Panel", TEXT, {"paneltext": NativeFunction(self._write_line, cost_ns=20_000)}, {})

    def take(self, inputs: bytearray) -> None:
        """Copy the keys into the image, at the begin of a cycle."""
        self._cycles += 1
        inputs[AREA_BYTE] = sum(is_down << number for number, is_down in enumerate(self.keys))

    def give(self) -> None:
        """Show the lamps of the image."""
        self.lamps = [bool(self._outputs[AREA_BYTE] >> number & 1) for number in range(LAMPS)]

    def _write_line(self, line: int, text: str) -> Results:
        if not 1 <= line <= LINES:
            return (False,)
        self.lines[line - 1] = text[:WIDTH]
        self._written[f"panel.line{line}"] = self._cycles
        return (True,)

    def points(self) -> Iterator[tuple[str, Point]]:
        for number in range(KEYS):
            yield (
                f"panel.key{number + 1}",
                Point(
                    partial(self.keys.__getitem__, number),
                    partial(self._press, number),
                    about="true while it is pressed",
                ),
            )
        for number in range(LAMPS):
            yield (
                f"panel.lamp{number + 1}",
                Point(
                    partial(self._is_lit, number), partial(self._switch, number), about="as the last cycle has left it"
                ),
            )
        for number in range(LINES):
            yield (
                f"panel.line{number + 1}",
                Point(
                    partial(self.lines.__getitem__, number),
                    partial(self._set_line, number),
                    about="line of the display",
                ),
            )

    def _press(self, number: int, value: Value) -> None:
        self.keys[number] = truth_in(value)

    def _is_lit(self, number: int) -> bool:
        return self.lamps[number]

    def _switch(self, number: int, value: Value) -> None:
        rest = self._outputs[AREA_BYTE] & ~(1 << number)
        self._outputs[AREA_BYTE] = rest | truth_in(value) << number
        self.lamps[number] = truth_in(value)

    def _set_line(self, number: int, value: Value) -> None:
        self.lines[number] = text_in(value, WIDTH)
