"""The state of each part of a rig in one word, and why: the rule behind the colours of the picture."""

from collections.abc import Mapping, Sequence
from enum import StrEnum
from typing import Any, Final, NamedTuple

from fieldrig.control.fault_questions import in_words
from fieldrig.text.digits import show_value
from fieldrig_page.part_faults import Fault, Faults, is_active, power_off

READY: Final = "ready"
WARNING: Final = "warning"
"""The word for a trouble that stops nothing; the keys of such troubles end with it."""
NO_ANSWER: Final = "no answer"
SILENCE: Final = "its process runs, but does not answer: it computes without end, or was stopped"
ENDED: Final = ("dead", "gone")
"""States of a process that does not run; in any other it runs, or is on its way."""


class Level(StrEnum):
    """The meaning of the colour of a part.  Each level has a word beside it."""

    OK = "ok"
    LATE = "late"
    FAULT = "fault"
    DOWN = "down"


class PartState(NamedTuple):
    level: Level
    word: str
    why: tuple[str, ...] = ()
    """A line for each fault, trouble or condition."""


class Process(NamedTuple):
    """The process that runs a part, as far as it is known."""

    state: str = READY
    late: str = ""
    """Words for how late the host is for it; "" if it is not."""
    restarts: int = 0
    is_silent: bool = False
    """True if it runs, and the part has not answered for some questions."""


def state_of_device(process: Process, faults: Faults, troubles: Mapping[str, Any]) -> PartState:
    """Return the state of a device: of its process, its power, its faults, and what it reports itself."""
    active = _active(faults)
    why = (*_in_lines(active), *(f"{key} {show_value(value)}" for key, value in troubles.items() if value))
    if (away := _away(process, why)) is not None:
        return away
    if power_off(faults) is not None:
        return PartState(Level.DOWN, "power off", why)
    present = [key for key, value in troubles.items() if value]
    is_warning = present and all(key.endswith(WARNING) for key in present)
    return _of_running(process, active, why, WARNING if is_warning else "trouble")


def state_of_bus(
    process: Process, faults: Faults, conditions: Mapping[str, str], figures: Mapping[str, float]
) -> PartState:
    """Return the state of a bus: of the process that runs it, its faults and its conditions, such as an open ring."""
    active = _active(faults)
    why = (*_in_lines(active), *conditions.values())
    if (away := _away(process, why)) is not None:
        return away
    if figures.get("ring_closed") == 0 and figures.get("cycles"):
        return PartState(Level.FAULT, "open", why)
    return _of_running(process, active, why, "alarm")


def _away(process: Process, why: tuple[str, ...]) -> PartState | None:
    """Return the state of a part whose process has ended or does not answer; None for any other."""
    if process.state in ENDED:
        return PartState(Level.DOWN, "down", why)
    if process.is_silent and process.state == READY:
        return PartState(Level.DOWN, NO_ANSWER, (*why, SILENCE))
    return None


def _of_running(process: Process, active: Sequence[Fault], why: tuple[str, ...], word: str) -> PartState:
    """Return the state of a part whose process runs; `word` is for something wrong without a fault that was added."""
    if active:
        return PartState(Level.FAULT, str(active[0].get("what", "fault")).replace("_", " "), why)
    if why:
        return PartState(Level.LATE if word == WARNING else Level.FAULT, word, why)
    if process.state != READY:
        return PartState(Level.LATE, process.state, why)
    if process.late:
        return PartState(Level.LATE, "late", (f"the host is late: {process.late}",))
    return PartState(Level.OK, READY)


def _active(faults: Faults) -> list[Fault]:
    return [fault for fault in faults.values() if is_active(fault)]


def _in_lines(faults: Sequence[Fault]) -> list[str]:
    return [f"fault: {in_words(fault)}" for fault in faults]
