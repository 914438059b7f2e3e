"""The nearest of the known names, for the message about a name that does not exist."""

from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Final

MOST_LISTED: Final = 40
"""Number of names that a message lists."""
ALMOST: Final = 0.75
"""How alike the names of two files must be, from 0 to 1."""


def closest(word: object, known: Sequence[str]) -> str:
    """Return `did you mean ...?`, or the known words, of very many only the first ones."""
    close = get_close_matches(str(word), known, n=1) or _regardless_of_case(str(word), known)
    if close:
        return f"did you mean {close[0]}?"
    more = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
    return f"there are: {', '.join(known[:MOST_LISTED])}{more}" if known else "there are none"


def nearest_file(path: Path) -> str:
    """Return `did you mean ...?` with what is in the same folder and has the nearest name; empty if nothing is near."""
    try:
        names = [] if path.exists() else [other.name for other in path.parent.iterdir()]
    except OSError:
        return ""
    close = get_close_matches(path.name, names, n=1, cutoff=ALMOST)
    return f"did you mean {path.with_name(close[0])}?" if close else ""


def _regardless_of_case(word: str, known: Sequence[str]) -> list[str]:
    return [name for name in known if name.casefold() == word.casefold()]
