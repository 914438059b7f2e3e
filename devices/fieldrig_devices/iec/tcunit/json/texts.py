"""Texts and bytes that a program hands over by their address, whatever they are declared as."""

import base64
from typing import Final, Protocol

from fieldrig_devices.iec.host import Results
from fieldrig_devices.iec.layout import STRING_KIND
from fieldrig_devices.iec.memory import Memory

COST_NS: Final = 5_000
LONGEST: Final = 255
"""Characters of the texts that are results; one that is longer is given as an empty one."""


class Limited(Protocol):
    """A parser or a writer, as one that has a limit of decimal places."""

    places: int


def short(text: str) -> Results:
    return (text if len(text) <= LONGEST else "",)


def size_of(text: str) -> Results:
    """Return the size of a text with its closing zero; 0 for an empty one."""
    return (len(text) + 1 if text else 0,)


def limit(of: Limited, places: int) -> Results:
    of.places = places
    return ()


def text_at(memory: Memory, address: int) -> str:
    """Return the text of a STRING; on the stack of a task, or in bytes that __NEW has given, too."""
    cell = memory.cells[address] if 0 <= address < len(memory.cells) else 0
    return cell if isinstance(cell, str) else memory.text_of(address, is_wide=False)


def put_text(memory: Memory, address: int, text: str, size: int) -> int:
    """Write a text into a STRING of some bytes; return its size with the closing zero.

    If it has no room, the STRING gets empty, and the result is 0.
    """
    has_room = len(text) < size
    given = text if has_room else ""
    if size > 0:
        if isinstance(memory.cells[address], str) and memory.kinds[address] in (0, STRING_KIND):
            memory.cells[address] = given
        else:
            memory.put_bytes_at(address, given.encode("latin-1") + b"\0")
    return len(text) + 1 if has_room else 0


class Given:
    """The texts and bytes that functions are given by address.  `memory` is that of the program, once it is loaded."""

    def __init__(self) -> None:
        self.memory: Memory | None = None

    def text(self, address: int) -> str:
        assert self.memory is not None
        return text_at(self.memory, address)

    def copy(self, text: str, address: int, size: int) -> Results:
        assert self.memory is not None
        return (put_text(self.memory, address, text, size),)

    def encoded(self, form: str, address: int, size: int) -> str:
        """Return bytes of the program as the text of Base64 or HexBinary."""
        assert self.memory is not None
        data = self.memory.bytes_at(address, size) if size > 0 else b""
        return base64.b64encode(data).decode("ascii") if form == "Base64" else data.hex()

    def put_bytes(self, address: int, data: bytes) -> None:
        assert self.memory is not None
        self.memory.put_bytes_at(address, data)
