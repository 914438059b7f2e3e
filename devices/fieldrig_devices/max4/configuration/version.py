"""Versions VXX.YY.ZZ, and the rule by which parts of a system are compatible.

Source: PacDrive manual 6181-6207 (digest PD-330 to PD-333), and the features that depend on versions (PD-335).
"""

import re
from typing import Final, NamedTuple


class Version(NamedTuple):
    """A version by its three numbers."""

    incompatible: int
    """XX, which counts incompatible changes."""
    upward: int
    """YY, which counts upwardly compatible changes."""
    compatible: int = 0
    """ZZ, which counts compatible changes."""

    def __str__(self) -> str:
        return f"V{self.incompatible:02}.{self.upward:02}.{self.compatible:02}"


def version_of(text: str) -> Version:
    """The first version in a text; ZZ may be missing.  ValueError if there is no version."""
    match = re.search(r"V(\d{2})\.(\d{2})(?:\.(\d{2}))?(?!\d)", text, re.ASCII)
    if match is None:
        raise ValueError(f"expected a version such as V00.15.00, got {text!r}")
    return Version(int(match[1]), int(match[2]), int(match[3] or 0))


def goes_with(upper: Version, lower: Version) -> bool:
    """True if XX is equal and the YY of `upper` is not below that of `lower`; ZZ does not matter.

    EPAS-4 is above the MAx-4, and the MAx-4 above MC-4 and IEC libraries.
    """
    return upper.incompatible == lower.incompatible and upper.upward >= lower.upward


IEC_STEPS: Final = Version(0, 6)
"""First version with IECsfc.lib for IEC steps (manual 3372, 1791)."""
TIME_STAMPS: Final = Version(0, 7)
"""First version with time stamps `DDD HH:MM:SS.sss` and 2 MByte of IEC data."""
LARGE_VARIABLES: Final = Version(0, 12)
"""First version with variables of 128 kByte."""
