"""Versions VXX.YY.ZZ, and which parts of a system may work together.

Source: PacDrive manual 6181-6207 (digest PD-330 to PD-333) and the features it binds to versions (PD-335).
"""

import re
from typing import Final, NamedTuple


class Version(NamedTuple):
    incompatible: int
    """XX"""
    upward: int
    """YY: upwardly compatible changes."""
    compatible: int = 0
    """ZZ"""

    def __str__(self) -> str:
        return f"V{self.incompatible:02}.{self.upward:02}.{self.compatible:02}"


def version_of(text: str) -> Version:
    """The first one in a text; ZZ may be left out.  ValueError if there is none."""
    found = re.search(r"V(\d{2})\.(\d{2})(?:\.(\d{2}))?(?!\d)", text, re.ASCII)
    if found is None:
        raise ValueError(f"{text!r} has no version: right would be V00.15.00")
    return Version(int(found[1]), int(found[2]), int(found[3] or 0))


def goes_with(upper: Version, lower: Version) -> bool:
    """Whether XX are equal and the upper's YY is not below the lower's; ZZ has no significance.

    EPAS-4 is above the MAx-4, and the MAx-4 above MC-4 and IEC libraries.
    """
    return upper.incompatible == lower.incompatible and upper.upward >= lower.upward


TIME_STAMPS: Final = Version(0, 7)
"""From here on stamps are `DDD HH:MM:SS.sss`, and IEC data have 2 MByte."""
LARGE_VARIABLES: Final = Version(0, 12)
