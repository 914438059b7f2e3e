"""The faults of one part of a rig, as it tells them: what acts, what is switched off, and where a ring is cut."""

from collections.abc import Mapping
from typing import Any

from fieldrig.device import POWER_OFF

Fault = Mapping[str, Any]
Faults = Mapping[int, Fault]
"""Faults by number."""


def faults_of(answer: Any) -> Faults:
    """Return the faults in an answer.  What has another form, as a kind of a user may give it, is left out."""
    if not isinstance(answer, Mapping):
        return {}
    return {
        int(number): fault for number, fault in answer.items() if str(number).isdecimal() and isinstance(fault, Mapping)
    }


def is_active(fault: Fault) -> bool:
    """Return whether a fault acts now; others wait, or are over."""
    return bool(fault.get("state") == "on")


def power_off(faults: Faults) -> int | None:
    """Return the number of the fault that has switched a device off; None if it has power."""
    off = (number for number, fault in faults.items() if fault.get("what") == POWER_OFF and is_active(fault))
    return next(off, None)


def cuts(faults: Faults) -> dict[str, int]:
    """Return the number of the fault that cuts the segment of a ring behind a station, by the station."""
    return {
        str(fault["after"]): number
        for number, fault in faults.items()
        if fault.get("what") == "break" and is_active(fault) and "after" in fault
    }
