"""The places of a rig that show the states of its machine, taken from what its devices offer.

These are states of drives, of nodes and of programs (CiA 402, charts, enumerations), numbers of diagnoses, and outputs.
Program branches and abort codes are no places: `eye.py` has them.
"""

import re
from collections.abc import Iterator, Mapping
from enum import StrEnum
from fnmatch import fnmatchcase
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from fieldrig.virtual.rig import Rig


class Sort(StrEnum):
    """The sorts of states that tell one state of a machine from another."""

    PROGRAMS = "programs"
    """Branches of programs that have run, and the active steps of charts."""
    STATES = "states"
    """States of drives and nodes, such as those of CiA 402, and of programs."""
    DIAGNOSES = "diagnoses"
    ABORTS = "aborts"
    """Codes with which a transfer was aborted or a request refused."""
    OUTPUTS = "outputs"


_STATE: Final = re.compile(
    r"(^|[./_]|[a-z0-9])(state|stage|phase|status|mode|program|node|ring|step)(_\d+)?", re.IGNORECASE
)
"""The last word of a key with a state."""
_OUTPUT: Final = re.compile(r"\boutput|_OUTPUT\b", re.IGNORECASE)
_STATUS_WORD: Final = re.compile(r"60[46]1:00")
"""The status word and the mode of a CiA 402 drive."""
MOST_OF_A_DEVICE: Final = 64
"""Places of one device; a program may have more variables than are worth to be read all the time."""


def state_places(rig: "Rig", sorts: frozenset[Sort]) -> Mapping[str, list[str]]:
    """Return the keys of the points that show the state of each device."""
    found = {device: list(_keys(rig, device, sorts))[:MOST_OF_A_DEVICE] for device in rig.config.devices}
    return {device: keys for device, keys in found.items() if keys}


def _keys(rig: "Rig", device: str, sorts: frozenset[Sort]) -> Iterator[str]:
    cls = rig.config.devices[device].cls
    shown = (*cls.trouble_keys, *getattr(cls, "diagnosis_keys", ()))
    values = rig.values(device)
    for key, fact in rig.facts(device).items():
        value = values[key]
        if Sort.DIAGNOSES in sorts and any(fnmatchcase(key, pattern) for pattern in shown):
            yield key
        elif Sort.STATES in sorts and _is_state(key, fact, value):
            yield key
        elif Sort.OUTPUTS in sorts and isinstance(value, bool) and _OUTPUT.search(fact["about"]):
            yield key


def _is_state(key: str, fact: Mapping[str, Any], value: object) -> bool:
    if isinstance(value, float) or fact["unit"]:
        return False
    return "states" in fact or bool(_STATE.fullmatch(re.split(r"[./]", key)[-1]) or _STATUS_WORD.fullmatch(key))
