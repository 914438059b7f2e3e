"""The code page of an old text: that of Windows (1252), or that of DOS in Western Europe (850).

Neither is named in a file.  Both give every byte a meaning, so the letters decide: those of a language are inside words
and are small behind small ones, while the other page has signs there, or capital letters.  Lines that are drawn in
comments are of DOS.  A text that leaves it open is one of Windows.  Code page 437 has letters and lines where 850 has
them.
"""

import re
from itertools import islice
from typing import Final

WINDOWS: Final = "cp1252"
DOS: Final = "cp850"
_MOST_LOOKED_AT: Final = 4_000
"""Characters that are looked at; a large file needs no more."""
_LETTERS: Final = frozenset("äöüßàâçéèêëîïôùûáíóúñåæøãõìòÄÖÜÀÂÇÉÈÊËÎÏÔÙÛÁÍÓÚÑÅÆØÃÕ")
_BEYOND_ASCII: Final = re.compile(r"[^\x00-\x7f]")
_DRAWN: Final = re.compile(rb"([\xb0-\xb2\xc4\xcd\xdb])\1{3}")
"""Parts of horizontal lines and of areas."""
_QUOTED: Final = re.compile(
    rb"(?<![A-Za-z])(\x84[^\r\n]{1,80}?[\x93\x94]|\x93[^\r\n]{1,80}?\x94|\x91[^\r\n]{1,80}?\x92)(?![A-Za-z])"
    rb"|(?<=[a-z])\x92(?=[a-z]{1,2}\b)|(?<=[\d ])[\x96\x97](?=[\d ])"
)
"""Quotes, apostrophes and dashes of Windows, whose codes are letters of DOS."""


def likely_code_page(data: bytes) -> str:
    """Return `cp1252` or `cp850` for the bytes of a text that is not UTF-8."""
    if _DRAWN.search(data):
        return DOS
    quotes = 2 * sum(1 for _ in islice(_QUOTED.finditer(data), _MOST_LOOKED_AT))
    windows, dos = (_likelihood(data.decode(page, errors="replace")) for page in (WINDOWS, DOS))
    return DOS if dos > windows + quotes else WINDOWS


def _likelihood(text: str) -> int:
    text = f" {text} "
    matches = islice(_BEYOND_ASCII.finditer(text), _MOST_LOOKED_AT)
    return sum(_weight(*text[match.start() - 1 : match.end() + 1]) for match in matches)


def _weight(before: str, character: str, behind: str) -> int:
    """Return 1 for a character that fits between its neighbours, -1 for one that does not, and 0 for any other."""
    if character == "°":
        return int(before.isdigit() or before == " ")
    if character == "µ":
        return int(behind.isalpha())
    is_inside = before.isalpha() or behind.isalpha()
    if character in _LETTERS and is_inside:
        return -1 if character.isupper() and before.islower() else 1
    return -1 if before.isalpha() and behind.isalpha() else 0
