"""The limits of the system.

Source: PacDrive manual chapter 9 (6015-6060), digest PD-310 to PD-321; 64 tasks and 40 axes by digest X2 and X1.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.max4.configuration.version import LARGE_VARIABLES, TIME_STAMPS, Version

KB: Final = 1024
MOST_AXES: Final = 47
CYCLES_MS: Final = (1, 2, 4)
SYSTEM_CLOCK_US: Final = 250


@dataclass(frozen=True, slots=True)
class Limits:
    """Sizes of memory and numbers of objects."""

    tasks: int = 64
    code_bytes: int = 2048 * KB
    data_bytes: int = 2048 * KB
    area_bytes: int = 64 * KB
    """Size of the areas of markers, inputs and outputs, each."""
    variable_bytes: int = 128 * KB
    """Size of an array, a structure, a list of global variables, or the variables of a function block."""
    stack_bytes: int = 10 * KB
    if_depth: int = 15
    bit_bytes: int = 4096
    """Size of the area for bit variables with AT."""

    @property
    def variable_area_bytes(self) -> int:
        return self.data_bytes - 3 * self.area_bytes


def limits_of(version: Version) -> Limits:
    return Limits(
        data_bytes=(2048 if version >= TIME_STAMPS else 1024) * KB,
        variable_bytes=(128 if version >= LARGE_VARIABLES else 32) * KB,
    )
