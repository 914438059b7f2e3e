"""The points in which a device shows the numbers of its diagnoses, and whether one is shown.

A MAx-4 has `DiagCode` of its own and of each axis, an ARP card the errors of its axes, a PAM the list of its errors,
a CANopen node the code of its last emergency message.  Devices name them in `trouble_keys` and `diagnosis_keys`.
"""

import re
from collections.abc import Callable, Iterable
from fnmatch import fnmatchcase
from typing import Final

from fieldrig.config.rig_file import RigConfig
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.text.nearest import closest

_NUMBER: Final = re.compile(r"0[xX][0-9a-fA-F]+|\d+")


def diagnosis_keys(config: RigConfig, device: str, known: Iterable[str]) -> list[str]:
    """Return the keys, among the known ones, of the points that show the diagnoses of a device.

    ControlError if there is no such device, or if it shows none.
    """
    if device not in config.devices:
        raise ControlError(f"the rig has no device {device!r}", closest(device, list(config.devices)))
    cls = config.devices[device].cls
    wanted = (*cls.trouble_keys, *cls.diagnosis_keys)
    keys = [key for key in known if any(fnmatchcase(key, pattern) for pattern in wanted)]
    if not keys:
        raise ControlError(f"{device} shows no diagnoses", "compare its points, such as tank/overflow")
    return keys


def shows(number: str) -> Callable[[Value], bool]:
    """Return a function that says whether a value is, or lists, a diagnosis: a number, or a word such as a name."""
    wanted = int(number, 0) if _NUMBER.fullmatch(number) and not re.fullmatch(r"0\d+", number) else None
    word = re.compile(rf"(?<!\w){re.escape(number)}(?!\w)", re.IGNORECASE)

    def is_shown(value: Value) -> bool:
        if isinstance(value, str):
            return word.search(value) is not None
        return wanted is not None and not isinstance(value, bool) and value == wanted

    return is_shown
