"""The place at which a thread is, for messages: the line of the master, not those of the libraries that it waits in."""

import linecache
import os
import threading
from collections.abc import Iterable
from types import FrameType
from typing import Final

OURS: Final = os.path.dirname(__file__) + os.sep  # noqa: PTH120  frames have texts
LIBRARY: Final = os.path.dirname(threading.__file__) + os.sep  # noqa: PTH120
PACKAGES: Final = ("site-packages", "dist-packages")
DEBUGGERS: Final = ("bdb.py", "pdb.py", "pydevd.py", "ipdb")
"""Names in the paths of debuggers; a thread in one of them waits for a person."""


def where(frame: FrameType | None) -> str:
    """Return file, line, function and text of the line at which a thread is; the innermost one of the master itself."""
    frames = [each for each in _outwards(frame) if not each.f_code.co_filename.startswith(OURS)]
    own = next((each for each in frames if not _is_library(each.f_code.co_filename)), frames[0] if frames else None)
    if own is None:
        return "at an unknown line"
    file, line = own.f_code.co_filename, own.f_lineno
    text = linecache.getline(file, line).strip()
    return f"{file}:{line} in {own.f_code.co_name}" + (f": {text}" if text else "")


def is_debugged(frame: FrameType | None) -> bool:
    """True if the thread is in a debugger."""
    return any(name in each.f_code.co_filename for each in _outwards(frame) for name in DEBUGGERS)


def _outwards(frame: FrameType | None) -> Iterable[FrameType]:
    while frame is not None:
        yield frame
        frame = frame.f_back


def _is_library(file: str) -> bool:
    is_package = any(name in file for name in PACKAGES)
    return is_package or file.startswith((LIBRARY, "<frozen"))
