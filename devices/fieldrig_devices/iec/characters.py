"""The characters of strings: Latin-1 in a STRING, and 16 bits of Unicode in a WSTRING.

Source: IEC 61131-3 edition 3, table 10: a character of a WSTRING has 16 bits.  The halves of a pair, with which UTF-16
writes a character beyond these, are no characters here, so that every text can be printed and sent to other programs.
"""

import re
from typing import Final

_OUTSIDE_NARROW: Final = re.compile("[^\0-\xff]")
_OUTSIDE_WIDE: Final = re.compile("[^\0-\ud7ff\ue000-\uffff]")
_UNKNOWN: Final = "\ufffd"


def first_outside(text: str, *, is_wide: bool) -> str | None:
    """Return the first character that the kind of string does not have; None if there is none."""
    match = (_OUTSIDE_WIDE if is_wide else _OUTSIDE_NARROW).search(text)
    return None if match is None else match[0]


def of_windows(text: str) -> str:
    """Return a text in which characters of Windows-1252 that Latin-1 does not have are those of the same bytes."""
    return _OUTSIDE_NARROW.sub(_byte_of_windows, text)


def _byte_of_windows(found: re.Match[str]) -> str:
    try:
        return found[0].encode("cp1252").decode("latin-1")
    except UnicodeEncodeError:
        return found[0]


def narrowed(text: str) -> str:
    """Return a text for a STRING, with ? for each character that it does not have."""
    return _OUTSIDE_NARROW.sub("?", text)


def widened(text: str) -> str:
    """Return a text for a WSTRING, with ? for each character that it does not have."""
    return _OUTSIDE_WIDE.sub("?", text)


def encoded(text: str, *, is_wide: bool) -> bytes:
    """Return the bytes of a text in memory, without the closing zero."""
    return text.encode("utf-16-le" if is_wide else "latin-1")


def decoded(data: bytes, *, is_wide: bool) -> str:
    """Return the text of bytes in memory, up to the closing zero."""
    if not is_wide:
        return data.partition(b"\0")[0].decode("latin-1")
    text = data[: len(data) & ~1].decode("utf-16-le", "surrogatepass")
    return _OUTSIDE_WIDE.sub(_UNKNOWN, text.partition("\0")[0])


def narrowed_code(code: int) -> int:
    """Return the code of a character of a WSTRING in a STRING; that of ? if it does not have the character."""
    return code if code <= 0xFF else ord("?")


def of_code(code: int) -> str:
    """Return the character with this code of 16 bits."""
    return _OUTSIDE_WIDE.sub(_UNKNOWN, chr(code))
