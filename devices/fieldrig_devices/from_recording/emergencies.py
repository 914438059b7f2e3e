"""The emergencies of a recording as faults of the emulated device, which begin and end at the recorded instants.

Source: CiA 301 version 4.2, 7.2.7: 0000h reports that an error is gone, and the error register has what is left.
"""

from collections.abc import Sequence
from functools import reduce
from operator import or_
from typing import Any, Final

from fieldrig.clock import MS
from fieldrig_devices.cia402.error_register import register_of
from fieldrig_devices.from_recording.life import Emergency

MOST: Final = 200
"""Emergencies of one node that it sends again."""
NO_ERROR: Final = 0
GENERIC: Final = 0x01


def faults_of(emergencies: Sequence[Emergency], start_ns: int, *, is_drive: bool) -> list[dict[str, Any]]:
    """Return the faults; the rig is switched on at `start_ns`.

    The error of a drive is a fault of its state machine, which stays until its master resets it.
    """
    found: list[dict[str, Any]] = []
    left: list[dict[str, Any]] = []
    for emergency in emergencies:
        at_ms = _ms(emergency.instant_ns - start_ns)
        if emergency.code == NO_ERROR:
            for fault in _ended(left, emergency.register):
                left.remove(fault)
                fault["duration_ms"] = max(round(at_ms - fault["start_ms"], 3), 0.001)
        elif len(found) < MOST and at_ms >= 0:
            before = reduce(or_, (fault.get("error_register", 0) for fault in left), 0)
            register = emergency.register & ~before
            fault = _of_drive(emergency, register) if is_drive else _of_node(emergency, register)
            found.append(fault | {"start_ms": at_ms})
            left.append(found[-1])
    return [fault | {"duration_ms": 1.0} for fault in found] if is_drive else found


def _of_node(emergency: Emergency, register: int) -> dict[str, Any]:
    """Return the fault for an emergency with these new bits of the error register."""
    info = emergency.info.rstrip(b"\0")
    keys = {"what": "emergency", "code": emergency.code, "error_register": register}
    return keys | ({"info": info.hex(" ")} if info else {})


def _of_drive(emergency: Emergency, register: int) -> dict[str, Any]:
    info = emergency.info.rstrip(b"\0")
    keys = {"what": "error", "code": emergency.code} | ({"info": info.hex(" ")} if info else {})
    return keys if register | GENERIC == register_of(emergency.code) | GENERIC else keys | {"error_register": register}


def _ended(left: Sequence[dict[str, Any]], register: int) -> list[dict[str, Any]]:
    """Return the errors that an "error reset" ends: all of them, or one of those whose bits are gone."""
    if not register:
        return list(left)
    gone = [fault for fault in left if fault.get("error_register", 0) & ~register & ~GENERIC]
    return (gone or list(left))[:1]


def _ms(time_ns: int) -> float:
    return round(time_ns / MS, 3)
