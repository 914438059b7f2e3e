"""The property of every rig: that no device raises an exception, and no devices answer each other without end."""

from collections.abc import Callable
from pathlib import Path
from traceback import extract_tb
from typing import Final

from fieldrig.errors import EndlessError, RigError

NOTHING_RAISES: Final = "no device raises an exception"
"""The property of every rig, beside those of its scenario: an error of ours, or of the author of a device."""


def raised_by(step: Callable[[], None]) -> str | None:
    """Do a step, and return what a device raised there, in words; None for nothing.

    RigError for what a user can fix.
    """
    try:
        step()
    except EndlessError as endless:
        return endless.what
    except RigError:
        raise
    except Exception as wrong:  # noqa: BLE001  whatever a device raises is what is looked for
        return _told(wrong)
    return None


def _told(wrong: Exception) -> str:
    """Return an exception with the line that raised it, and the device and instant of it."""
    *_, frame = extract_tb(wrong.__traceback__)
    notes = "; ".join(getattr(wrong, "__notes__", ()))
    return f"{type(wrong).__name__}: {wrong} ({Path(frame.filename).name}:{frame.lineno}){notes and f' {notes}'}"
