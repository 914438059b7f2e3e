"""The limits of the system, and how those of a program depend on the version of the controller.

Source: PacDrive manual chapter 9 (6015-6060), digest PD-310 to PD-321 and PD-335; 40 axes by digest X1.
"""

from dataclasses import replace
from typing import Final

from fieldrig_devices.iec.limits import KB, MAX_4, Limits
from fieldrig_devices.max4.configuration.version import IEC_STEPS, LARGE_VARIABLES, TIME_STAMPS, Version

MOST_AXES: Final = 47
CYCLES_MS: Final = (1, 2, 4)


def limits_of(version: Version) -> Limits:
    """Return what a program may need on a controller of this version."""
    return replace(
        MAX_4,
        data=(2048 if version >= TIME_STAMPS else 1024) * KB,
        variable=(128 if version >= LARGE_VARIABLES else 32) * KB,
        has_iec_steps=version >= IEC_STEPS,
    )
