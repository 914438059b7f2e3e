"""A source file of a project: its name and its text, from the bytes that a tool has written.

Today's tools write UTF-8, some with a mark, or UTF-16 with its mark.  EPAS-4 and other tools of its time write the code
page of Windows, and those of DOS write its own (`code_page`), end a file by 1Ah, and fill the rest of its last block.
"""

import codecs
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from fieldrig_devices.languages.code_page import likely_code_page

LONGEST: Final = 16 << 20
"""Longest source file in bytes."""
END_OF_TEXT: Final = "\x1a"
"""Ends a text file of CP/M and DOS; what follows is left over from an earlier text."""
_SAMPLE: Final = 4_000
"""Bytes of a file from which its encoding is judged, if it has no mark."""
_MARKS: Final = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
_LINE_END: Final = re.compile(r"\r?\r\n|\r")
"""Two returns come from a file that was transferred as text twice."""


@dataclass(frozen=True, slots=True)
class SourceFile:
    name: str
    text: str
    path: Path | None = field(default=None, compare=False)
    """The file itself, if its name is only a part of its path."""


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


def found_beside(folder: Path, name: str) -> Path | None:
    r"""Return the file that a program includes by the name that its system had for it, or None.

    The name is relative to `folder`, has / or \\ between its parts, and its letters may be of another case; a file with
    its very spelling comes first.  Nothing outside of the folder is found.
    """
    parts = _inside(name)
    candidates = [folder.resolve()] if parts else []
    for part in parts:
        candidates = [path for candidate in candidates for path in _called(candidate, part)]
    return next((path for path in candidates if path.is_file() and _is_within(path, folder)), None)


def _inside(name: str) -> Sequence[str]:
    """Return the parts of a path below a folder; none for a path that leads out of it."""
    names: list[str] = []
    for part in name.replace("\\", "/").split("/"):
        if part == ".." and not names:
            return ()
        if part == "..":
            names.pop()
        elif part not in ("", "."):
            names.append(part)
    return () if name[:1] in ("/", "\\") else names


def _called(folder: Path, name: str) -> Iterator[Path]:
    """Yield what a folder has under a name, the same spelling first."""
    try:
        entries = sorted(folder.iterdir(), key=lambda path: (path.name != name, path.name))
    except OSError:  # no folder, or one that may not be read
        return
    yield from (path for path in entries if path.name.casefold() == name.casefold())


def _is_within(path: Path, folder: Path) -> bool:
    """False for a link that leads out of the folder."""
    return path.resolve().is_relative_to(folder.resolve())
