"""The font HEXA of the seven-segment display (Appendix C).

Source: the pictures of the appendix are lost.  Digits, the letters A to H and a to h, and the bars that the text of the
table still shows are drawn; other capital letters have their usual shapes, and all other codes are blank.  A setting
draws characters in another way.
"""

from collections.abc import Mapping
from typing import Final

FIRST, LAST = 32, 127
POINT: Final = "p"
"""The decimal point beside the segments a to g."""
_SHAPES: Final[Mapping[str, str]] = {
    " ": "", "0": "abcdef", "1": "bc", "2": "abdeg", "3": "abcdg", "4": "bcfg", "5": "acdfg", "6": "acdefg",
    "7": "abc", "8": "abcdefg", "9": "abcdfg",
    "A": "abcefg", "B": "cdefg", "C": "adef", "D": "bcdeg", "E": "adefg", "F": "aefg", "G": "acdef", "H": "bcefg",
    "I": "ef", "J": "bcd", "L": "def", "N": "ceg", "O": "abcdef", "P": "abefg", "R": "eg", "S": "acdfg", "T": "defg",
    "U": "bcdef", "Y": "bcdfg",
    "a": "abcefg", "b": "cdefg", "c": "deg", "d": "bcdeg", "e": "adefg", "f": "aefg", "g": "acdef", "h": "cefg",
    "-": "g", "_": "d", "i": "g", "j": "g", "m": "g", "z": "g", "p": "cdeg", "q": "cdeg", "s": "cdeg", "t": "cdeg",
    "r": "ceg", "y": "ceg", "u": "cde", "x": "cde", "v": "deg", "w": "deg",
    "'": "f", "k": "f", "o": "b", "l": "c", "n": "e", ".": POINT,
}  # fmt: skip


def segments_of(code: int, own: Mapping[str, str] = _SHAPES) -> str:
    """Return the segments that a character lights, a to g clockwise from the top with g in the middle.

    `own` has the characters of a machine that differ from the font.
    """
    character = chr(code)
    return own.get(character, _SHAPES.get(character, "")) if FIRST <= code <= LAST else ""
