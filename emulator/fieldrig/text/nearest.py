"""The nearest of the known names, for the message about a name that does not exist."""

import re
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Final

MOST_LISTED: Final = 40
"""Number of names that a message lists."""
ALMOST: Final = 0.75
"""How alike the names of two files must be, from 0 to 1."""

SHORTEST_SLIP: Final = 3
"""Letters of the shortest name that counts as mistyped."""
LONG_WORD: Final = 8
"""Letters of a name in which two may be wrong."""
_NUMBER: Final = re.compile(r"[0-9]+")
_PARTS: Final = re.compile(r"[0-9]+|[A-Za-z]+")


def closest(word: object, known: Sequence[str]) -> str:
    """Return `did you mean ...?`, or the known words, of very many only the first ones."""
    close = get_close_matches(str(word), known, n=1) or _regardless_of_case(str(word), known)
    if close:
        return f"did you mean {close[0]}?"
    more = f" and {len(known) - MOST_LISTED} more" if len(known) > MOST_LISTED else ""
    return f"there are: {', '.join(known[:MOST_LISTED])}{more}" if known else "there are none"


def is_slip(word: str, other: str, most: int | None = None) -> bool:
    """Return whether two different names are so alike that one may be the other, mistyped.

    That is: they differ in no more than `most` letters that are wrong, missing, too many or in the wrong order, or only
    in upper and lower case.  By default a word of eight letters may differ in two, a word of four in one.
    """
    length = min(len(word), len(other))
    if word == other or length < SHORTEST_SLIP:
        return False
    if most is None:
        most = 2 if length >= LONG_WORD else 1
    return word.casefold() == other.casefold() or _differs_by(word, other, most)


def is_numbered(word: str, other: str) -> bool:
    """Return whether two names differ only in numbers and single letters that count, such as `x1_a` and `x2_b`."""
    if _NUMBER.sub("", word) == _NUMBER.sub("", other):
        return word != other
    parts, others = _PARTS.findall(word), _PARTS.findall(other)
    if len(parts) != len(others) or _PARTS.sub("", word) != _PARTS.sub("", other):
        return False
    differing = [pair for pair in zip(parts, others, strict=True) if pair[0] != pair[1]]
    return bool(differing) and all(_is_count(part) for pair in differing for part in pair)


def is_mistyped(word: str, other: str, most: int | None = None) -> bool:
    """Return whether one name is probably the other, mistyped: a slip as in `is_slip`, and not only in numbers."""
    return is_slip(word, other, most) and not is_numbered(word, other)


def nearest_file(path: Path) -> str:
    """Return `did you mean ...?` with what is in the same folder and has the nearest name; empty if nothing is near.

    A name without its ending, such as `lab` for `lab.yaml`, is the nearest.
    """
    try:
        names = [] if path.exists() else [other.name for other in path.parent.iterdir()]
    except OSError:
        return ""
    same = sorted((name for name in names if Path(name).stem == path.name), key=lambda name: not name.endswith(".yaml"))
    close = same or get_close_matches(path.name, names, n=1, cutoff=ALMOST)
    return f"did you mean {path.with_name(close[0])}?" if close else ""


def _is_count(part: str) -> bool:
    return part.isdecimal() or len(part) == 1


def _differs_by(word: str, other: str, most: int) -> bool:
    """Return whether at most `most` letters make one of the other (distance of optimal string alignment)."""
    if abs(len(word) - len(other)) > most:
        return False
    before: list[int] = []
    row = list(range(len(other) + 1))
    for at, letter in enumerate(word):
        new = [at + 1]
        for to, wanted in enumerate(other):
            best = min(row[to] + (letter != wanted), row[to + 1] + 1, new[to] + 1)
            if at and to and letter == other[to - 1] and word[at - 1] == wanted:
                best = min(best, before[to - 1] + 1)
            new.append(best)
        if min(new) > most:
            return False
        before, row = row, new
    return row[-1] <= most


def _regardless_of_case(word: str, known: Sequence[str]) -> list[str]:
    return [name for name in known if name.casefold() == word.casefold()]
