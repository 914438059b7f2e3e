"""The properties of every rig: no device raises an exception or computes without end, and its master does not fail."""

from collections.abc import Callable
from pathlib import Path
from traceback import extract_tb
from typing import Final, NamedTuple

from fieldrig.errors import EndlessError, RigError
from fieldrig.virtual.stuck import StuckError

NOTHING_RAISES: Final = "no device raises an exception"
"""The property of every rig, beside those of its scenario: an error of ours, or of the author of a device."""
TIME_PASSES: Final = "no device computes without end"
MASTER_WORKS: Final = "the master does not fail"
"""The property of every scenario with a master: it ends in no exception, and with no exit code but 0."""
OF_EVERY_RIG: Final = (NOTHING_RAISES, TIME_PASSES, MASTER_WORKS)
"""The properties of every rig; what was raised is a part of a finding's name, as each is a fault of its own."""


class Raised(NamedTuple):
    property: str
    what: str


def raised_by(step: Callable[[], None]) -> Raised | None:
    """Do a step, and return what a device raised there, in words; None for nothing.

    RigError for what a user can fix.
    """
    try:
        step()
    except EndlessError as endless:
        return Raised(NOTHING_RAISES, endless.what)
    except RigError:
        raise
    except StuckError as stuck:
        return Raised(TIME_PASSES, str(stuck))
    except Exception as wrong:  # noqa: BLE001  whatever a device raises is what is looked for
        return Raised(NOTHING_RAISES, _told(wrong))
    return None


def _told(wrong: Exception) -> str:
    """Return an exception with the line that raised it, and the device and instant of it."""
    *_, frame = extract_tb(wrong.__traceback__)
    notes = "; ".join(getattr(wrong, "__notes__", ()))
    return f"{type(wrong).__name__}: {wrong} ({Path(frame.filename).name}:{frame.lineno}){notes and f' {notes}'}"
