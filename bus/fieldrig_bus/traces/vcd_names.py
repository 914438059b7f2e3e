"""Names of wires as hierarchical names of a VCD file (IEEE 1364-2005, 18.2.3: simple identifiers).

The bus is the outermost scope, and each dot of a name begins another one: `cell.valve` on the bus `wires` is `valve` in
the scope `cell` in the scope `wires`.  Each character that an identifier cannot have becomes an underscore.
"""

import re
from collections.abc import Iterable

Path = tuple[str, ...]
"""Scopes from the outermost one, then the name of the variable."""

_FOREIGN = re.compile(r"[^A-Za-z0-9_]")


def legal_paths(names: Iterable[tuple[str, str]]) -> list[Path]:
    """Return a path for each (bus, wire), in their order.  A path that another wire has already gets a number."""
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
    found = _FOREIGN.sub("_", word)
    return found if found[:1].isalpha() or found[:1] == "_" else f"_{found}"
