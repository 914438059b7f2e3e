"""Legal names, exact numbers and quotes in value change dumps (IEEE 1364-2005, clause 18)."""

import json
import re
from collections.abc import Iterable
from typing import BinaryIO

Path = tuple[str, ...]
"""Scopes from the outermost one, then the name of the variable."""

_FOREIGN = re.compile(r"[^A-Za-z0-9_]")


def legal_paths(names: Iterable[tuple[str, str]]) -> list[Path]:
    """Return a path of hierarchical names for each (bus, wire), in their order.

    The bus is the outermost scope, and each dot of a name begins another one: `cell.valve` on the bus `wires` is
    `valve` in the scope `cell` in the scope `wires`.  Each character that a simple identifier cannot have (IEEE
    1364-2005, 18.2.3) becomes an underscore.  A path that another wire has already gets a number.
    """
    used: set[Path] = set()
    paths: list[Path] = []
    for bus, wire in names:
        first = path = (_identifier(bus), *map(_identifier, wire.split(".")))
        number = 2
        while path in used:
            path = (*first[:-1], f"{first[-1]}_{number}")
            number += 1
        used.add(path)
        paths.append(path)
    return paths


def _identifier(word: str) -> str:
    name = _FOREIGN.sub("_", word)
    return name if name[:1].isalpha() or name[:1] == "_" else f"_{name}"


class Exact(float):
    """A number that pyvcd writes with all its digits; its own format, "%.16g", is one too short for some."""

    def __format__(self, spec: str) -> str:
        return repr(float(self))


class ExactWhole(int):
    """A whole number that pyvcd writes with all its digits."""

    def __format__(self, spec: str) -> str:
        return str(int(self))


def quoted(text: str) -> str:
    return json.dumps(text).replace("$", "\\u0024")


class Ascii:
    """Text for a file of bytes that need not be able to do more than write."""

    def __init__(self, file: BinaryIO) -> None:
        self._file = file

    def write(self, text: str) -> int:
        return self._file.write(text.encode("ascii"))

    def flush(self) -> None:
        """Bytes wait in the file."""
