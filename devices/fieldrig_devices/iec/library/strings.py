"""The string functions of CoDeSys V2.3's Standard.lib.  Positions count from 1; no result is longer than 255.

Lengths below 0 count as 0.  A position outside the text changes nothing for DELETE and REPLACE, inserts at the nearest
end, and makes MID empty, so no argument is a fault.  DELETE takes the position 0 in front of the text as the first of
its characters: public programs of TwinCAT delete all up to a point by `DELETE(text, FIND(text, '.') + 1, 0)`.
"""

from typing import Final

LONGEST: Final = 255
"""Length of the arguments and results of these functions."""


def left(text: str, size: int) -> str:
    return text[:size] if size > 0 else ""


def right(text: str, size: int) -> str:
    return text[-size:] if size > 0 else ""


def middle(text: str, size: int, position: int) -> str:
    """MID: `size` characters from `position` on."""
    return text[position - 1 : position - 1 + size] if position > 0 and size > 0 else ""


def concatenated(first: str, second: str, *others: str) -> str:
    text = first + second
    if others:
        text += "".join(others)
    return text if len(text) <= LONGEST else text[:LONGEST]


def inserted(text: str, part: str, position: int) -> str:
    """INSERT: `part` behind the first `position` characters."""
    place = max(position, 0)
    return (text[:place] + part + text[place:])[:LONGEST]


def deleted(text: str, size: int, position: int) -> str:
    """DELETE: `size` characters from `position` on are gone."""
    if not 0 <= position <= len(text):
        return text
    return text[: max(position - 1, 0)] + text[max(position - 1 + max(size, 0), 0) :]


def replaced(text: str, part: str, size: int, position: int) -> str:
    """REPLACE: `part` instead of `size` characters from `position` on."""
    if not 1 <= position <= len(text):
        return text
    return (text[: position - 1] + part + text[position - 1 + max(size, 0) :])[:LONGEST]


def found(text: str, part: str) -> int:
    """FIND: the position of the first `part` in `text`; 0 if there is none, or if `part` is empty."""
    return text.find(part) + 1 if part else 0
