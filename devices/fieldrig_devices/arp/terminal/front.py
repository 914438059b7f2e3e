"""The front of a terminal: its screen, its LEDs above the function keys, and the keypad.

Source: manual 4.5 for the keys and LEDs of both models.  Its drawing is lost, so their places are ours: the numbers as
on a desk calculator, with the keys that end or correct an entry beside them.
"""

from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig.front import Front, Gap, Group, Key, Led, Lines, Part, Plate, Text
from fieldrig_devices.arp.terminal import panel
from fieldrig_devices.arp.terminal.panel import Model
from fieldrig_devices.arp.terminal.screen import COLUMNS, LINES

_KEYPAD: Final[dict[Model, str]] = {
    "TR4": "7 8 9 ESC  4 5 6 DEL  1 2 3 END  0 POINT MINUS CR",
    "TR5": "7 8 9 ESC  4 5 6 DEL  1 2 3 SHIFT  0 POINT MINUS CR",
}
_ARROWS: Final[dict[Model, str]] = {"TR4": "- UP -  LEFT DOWN RIGHT", "TR5": "- UP -  - DOWN -"}
_FUNCTIONS: Final[dict[Model, Sequence[str]]] = {
    "TR4": ("F1 F2 F3 F4 F5 F6", "F7 F8 F9 F10 F11 F12"),
    "TR5": ("F1 F2 F3 F4", "FA FB AUTO -"),
}
_SIGNS: Final = {"POINT": ".", "MINUS": "-", "LEFT": "←", "RIGHT": "→", "UP": "↑", "DOWN": "↓"}
_NAMES: Final = {"LEFT": "left", "RIGHT": "right", "UP": "up", "DOWN": "down", "POINT": "point", "MINUS": "minus"}


def front_of(model: Model) -> Front:
    """Return the front of a model."""
    screen = Lines("screen", "screen", "the screen", columns=COLUMNS, rows=LINES, texts="texts", cursor="cursor")
    functions = _FUNCTIONS[model]
    return Front(
        Plate("ASA-RT", model),
        [
            Group([screen]),
            Group([*_functions(model)], "function keys", columns=len(functions[0].split())),
            Group(_keys(_KEYPAD[model]), "keypad", columns=4),
            Group(_keys(_ARROWS[model]), "cursor keys", columns=3),
            Group([Text("printer", "printer", "the lines that it printed last")], "printer"),
            Group(
                [
                    Text("state of the node", "nmt.state", good=("operational",), bad=("stopped",)),
                    Text("node-ID", "node_id"),
                ],
                "CANopen",
            ),
        ],
    )


def _functions(model: Model) -> Iterator[Part]:
    """Yield rows of LEDs, each above the row of its keys."""
    leds = panel.leds(model)
    for row in _FUNCTIONS[model]:
        names = row.split()
        if not leds.keys().isdisjoint(names):
            yield from (Led(name, f"led.{name}", colour="yellow") if name in leds else Gap() for name in names)
        yield from _keys(row)


def _keys(names: str) -> list[Part]:
    return [Gap() if name == "-" else _key(name) for name in names.split()]


def _key(name: str) -> Key:
    return Key(_SIGNS.get(name, name), f"key.{name}", _NAMES.get(name, ""))
