"""A source text on the standard input and output of a command, for editors: the path is `-`."""

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from fieldrig.errors import UsageError

_STANDARD: Final = Path("-")


def is_standard(paths: Sequence[Path]) -> bool:
    """True if the path is `-`.  UsageError if it is one of several."""
    if _STANDARD in paths and len(paths) > 1:
        raise UsageError("- is the standard input, and cannot be one of several files", "expected - alone")
    return list(paths) == [_STANDARD]


def read_standard() -> str:
    """Return the text of the standard input.  UsageError if it cannot be read."""
    from fieldrig.text.source_text import decoded

    try:
        return decoded(sys.stdin.buffer.read())
    except ValueError as cause:
        raise UsageError("the standard input cannot be read", str(cause)) from cause


def write_standard(text: str) -> None:
    """Write a text to the standard output in UTF-8, whatever encoding a terminal has."""
    sys.stdout.buffer.write(text.encode())
    sys.stdout.buffer.flush()
