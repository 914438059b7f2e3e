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


_STATES: Final = frozenset({"state", "stage", "phase", "status", "mode", "program", "node", "ring", "step"})
"""The last words of keys with a state, such as `axis_state`, `AxisState` and `g_lState_1`."""
_WORD: Final = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])")
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
        is_diagnosis = any(fnmatchcase(key, pattern) for pattern in shown)
        is_output = isinstance(values[key], bool) and bool(_OUTPUT.search(fact["about"]))
        is_sort = {
            Sort.DIAGNOSES: is_diagnosis,
            Sort.OUTPUTS: is_output,
            Sort.STATES: _is_state(key, fact, values[key]),
        }
        if any(is_one and sort in sorts for sort, is_one in is_sort.items()):
            yield key


def _is_state(key: str, fact: Mapping[str, Any], value: object) -> bool:
    if isinstance(value, float) or fact["unit"]:
        return False
    words = _WORD.findall(re.split(r"[./]", key)[-1])
    return "states" in fact or bool(words and words[-1].lower() in _STATES) or bool(_STATUS_WORD.fullmatch(key))
