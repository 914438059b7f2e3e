"""The names of a register's numbers that a list has in a column, such as `0=Off; 1=On` or `0: off, 1: heating`."""

import re
from typing import Final

_ENTRY: Final = re.compile(r"(0x[0-9a-f]+|-?\d+)\s*(?:=>|->|[=:–—-])\s*(.+)", re.IGNORECASE | re.DOTALL)
_SEPARATORS: Final = (r"[;\n\r|]", r",(?=\s*(?:0x[0-9a-f]+|-?\d+)\s*(?:=>|->|[=:–—-]))", r"/(?=\s*-?\d+\s*[=:])")


def values_in(text: str) -> dict[int, str]:
    """Return the names by their numbers; empty if the text says something else, such as a range."""
    parts = [text]
    for separator in _SEPARATORS:
        parts = [part for whole in parts for part in re.split(separator, whole, flags=re.IGNORECASE)]
    found = [_ENTRY.fullmatch(part.strip()) for part in parts if part.strip()]
    named = {int(entry[1], 0): " ".join(entry[2].split()) for entry in found if entry is not None and _is_number(entry)}
    is_whole = all(entry is not None and _is_number(entry) for entry in found) and len(named) == len(found)
    is_named = not all(re.fullmatch(r"-?[\d.]+", name) for name in named.values())
    return named if is_whole and is_named and len(set(named.values())) == len(named) else {}


def _is_number(entry: re.Match[str]) -> bool:
    """True unless the digits are those of an octal number, which Python does not read."""
    return re.fullmatch(r"-?0\d+", entry[1]) is None
