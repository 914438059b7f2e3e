"""The keys and LEDs of both terminals, with the card's flag and the bit on the bus for each.

Source: manual 4.5, row by row.
"""

from typing import Final, Literal

Model = Literal["TR4", "TR5"]

FIRST_LED_FLAG: Final = 218
FIRST_KEY_FLAG: Final = 225
LAST_KEY_FLAG: Final = 256

# Flag: on TR4, on TR5.
_LEDS: Final[dict[int, tuple[str | None, str | None]]] = {
    218: (None, "F1"),
    219: ("F12", "F2"),
    220: ("F11", "F3"),
    221: ("F10", "F4"),
    222: ("F9", "FA"),
    223: ("F8", "FB"),
    224: ("F7", "AUTO"),
}
_KEYS: Final[dict[int, tuple[str | None, str | None]]] = {
    225: ("1", "1"),
    226: ("2", "2"),
    227: ("3", "3"),
    228: ("4", "4"),
    229: ("5", "5"),
    230: ("6", "6"),
    231: ("7", "7"),
    232: ("8", "8"),
    233: ("9", "9"),
    234: ("0", "0"),
    235: ("POINT", "POINT"),
    236: ("MINUS", "MINUS"),
    237: ("CR", "CR"),
    238: ("ESC", "ESC"),
    239: ("END", "SHIFT"),
    240: ("DEL", "DEL"),
    241: ("LEFT", None),
    242: ("RIGHT", None),
    243: ("DOWN", "DOWN"),
    244: ("UP", "UP"),
    245: ("F1", "F1"),
    246: ("F2", "F2"),
    247: ("F3", "F3"),
    248: ("F4", "F4"),
    249: ("F5", "FA"),
    250: ("F6", "FB"),
    251: ("F7", "AUTO"),
    252: ("F8", None),
    253: ("F9", None),
    254: ("F10", None),
    255: ("F11", None),
    256: ("F12", None),
}
_COLUMN: Final[dict[Model, int]] = {"TR4": 0, "TR5": 1}


def keys(model: Model) -> dict[str, int]:
    """Bit in object 2000h, by name of the key."""
    return _bits(_KEYS, model, FIRST_KEY_FLAG)


def leds(model: Model) -> dict[str, int]:
    """Bit in object 2001h, by name of the LED."""
    return _bits(_LEDS, model, FIRST_LED_FLAG)


def _bits(table: dict[int, tuple[str | None, str | None]], model: Model, first: int) -> dict[str, int]:
    names = {flag: row[_COLUMN[model]] for flag, row in table.items()}
    return {name: flag - first for flag, name in names.items() if name is not None}
