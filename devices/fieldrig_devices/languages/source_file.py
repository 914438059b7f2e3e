"""A source file of a project: its name and its text, from the bytes that a tool has written.

Today's tools write UTF-8, some with a mark, or UTF-16 with its mark.  EPAS-4 and other tools of its time write the code
page of Windows.
"""

import codecs
from dataclasses import dataclass
from typing import Final

LONGEST: Final = 16 << 20
"""Longest source file in bytes."""
_MARKS: Final = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))


@dataclass(frozen=True, slots=True)
class SourceFile:
    name: str
    text: str


def decoded(data: bytes) -> str:
    """Return the text of a file.  ValueError for a file that is longer than LONGEST; no other bytes are refused."""
    if len(data) > LONGEST:
        raise ValueError(f"{len(data)} bytes are too long for a source file: expected at most {LONGEST}")
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data.decode(encoding, errors="replace")
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")
