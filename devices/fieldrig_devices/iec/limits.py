"""The limits of a project on a controller, which it hands to the compiler.

Source: PacDrive manual 6015 to 6060 (digest PD-310 to PD-318).  What differs between versions is in
`max4/configuration/limits.py`.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_devices.iec.layout import AREA_SIZE, STACK_SIZE

KB: Final = 1024


@dataclass(frozen=True, slots=True)
class Limits:
    """Sizes of memory and numbers of objects.  The defaults are those of a present MAx-4."""

    tasks: int = 64
    """PD-310; PD-063 has 127, the data table has 64 (X2)."""
    code: int = 2048 * KB
    """Bytes of the program's code (PD-311)."""
    data: int = 2048 * KB
    """Bytes of all variables and the three areas together (PD-312)."""
    area: int = AREA_SIZE
    """Bytes of each of %I, %Q and %M (PD-314)."""
    retain: int = 101 * KB
    """Bytes of RETAIN variables, with the largest memory that a controller may have for them (PD-315)."""
    variable: int = 128 * KB
    """Bytes of an array, a structure, a list of global variables, or an instance (PD-316)."""
    stack: int = STACK_SIZE
    """Bytes of the variables of functions that call one another (PD-317)."""
    parts: int = 1_000_000
    """Components and elements of a type or a variable, at any level.  Empty structures take no memory, but 30 of them,
    each twice in the next one, would take the time of the host."""
    if_depth: int = 15
    """PD-318."""
    has_iec_steps: bool = True
    """Steps with actions and qualifiers, which need IECsfc.lib (PD-204)."""

    @property
    def variables(self) -> int:
        """Bytes of all variables: the data without the three areas (PD-313)."""
        return self.data - 3 * self.area


MAX_4: Final = Limits()

# Our own limits of a compilation, so that no text takes the memory of the host.
MOST_CHARACTERS: Final = 8 << 20
"""Characters of all sources of a project together."""
MOST_STATEMENTS: Final = 500_000
"""Semicolons in all sources together."""
MOST_MESSAGES: Final = 1_000
"""Messages about one file, and about the declarations and bodies of all files."""
