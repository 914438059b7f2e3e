"""The text of a source file, from the bytes that a tool has written.

Today's tools write UTF-8, some with a mark, or UTF-16 with its mark.  EPAS-4 and other tools of its time write the code
page of Windows, and those of DOS write its own (`code_page`), end a file by 1Ah, and fill the rest of its last block.
"""

import codecs
import re
from typing import Final

from fieldrig.text.code_page import likely_code_page

LONGEST: Final = 16 << 20
"""Longest source file in bytes."""
END_OF_TEXT: Final = "\x1a"
"""Ends a text file of CP/M and DOS; what follows is left over from an earlier text."""
_SAMPLE: Final = 4_000
"""Bytes of a file from which its encoding is judged, if it has no mark."""
_MARKS: Final = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_LINE_END: Final = re.compile(r"\r?\r\n|\r")
"""Two returns come from a file that was transferred as text twice."""


def decoded(data: bytes) -> str:
    r"""Return the text of a file, with `\n` at the ends of its lines, whatever the file has there.

    ValueError for a file that is longer than LONGEST; no other bytes are refused.
    """
    if len(data) > LONGEST:
        raise ValueError(f"{len(data)} bytes are too long for a source file: expected at most {LONGEST}")
    text = _characters(data).partition(END_OF_TEXT)[0].rstrip("\0")
    return _LINE_END.sub("\n", text)


def _characters(data: bytes) -> str:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return data.decode(encoding, errors="replace")
    if (unmarked := _without_mark(data)) is not None:
        return data.decode(unmarked, errors="replace")
    data = data.partition(END_OF_TEXT.encode())[0]
    try:
        return data.decode()
    except UnicodeDecodeError:
        return data.decode(likely_code_page(data), errors="replace")


def _without_mark(data: bytes) -> str | None:
    """Return the encoding of a file in UTF-16 without a mark, or None.

    Most characters of a program have a byte 0 in it, all on the same side; no other encoding has that.  Zeros at the
    end are what an old disk has behind a text.
    """
    body = data[:_SAMPLE].rstrip(b"\0")
    zeros = body.count(0)
    for encoding, first in (("utf-16-le", 1), ("utf-16-be", 0)):
        side = body[first::2]
        if zeros and side.count(0) == zeros and 4 * zeros >= len(side):
            return encoding
    return None
