"""The cost of a program in processor time and in memory: a stated model, because the manual gives no figures.

Every operation that the source asks for costs a fixed time, whatever Python makes of it; a library function has its own
cost (`library/overload.py`, `host.py`).  The defaults are the orders of magnitude of a controller of 2003; `scale` is
for calibration: run the same program on a machine, and divide its load by the load here.
"""

from dataclasses import dataclass
from typing import Final

CODE_PER_NS: Final = 0.2
"""Bytes of machine code for a nanosecond of cost: 4 to 5 bytes for an instruction of 20 ns."""
CODE_PER_ROUTINE: Final = 32
"""Bytes of entry and exit code."""


@dataclass(frozen=True, slots=True)
class Costs:
    """Nanoseconds of processor time by kind of operation."""

    access: int = 20
    """Reading or writing a variable, and each index or pointer on the way to it."""
    operation: int = 20
    """An operation on integers, bits or times other than the following."""
    multiply: int = 30
    divide: int = 150
    real: int = 60
    """An operation on REAL or LREAL."""
    text: int = 500
    """Copying or comparing a string."""
    copy: int = 2
    """Copying a byte of a structure or array."""
    jump: int = 20
    call: int = 200
    end: int = 100
    parameter: int = 2_000
    """Access to a parameter of a configuration object."""
    io: int = 500
    """Access to %I or %Q, which goes to the terminals at once (PD-070)."""
    scale: float = 1.0

    def scaled(self, cost_ns: int) -> int:
        """Return a cost for this controller; at least 1, so that every loop takes time."""
        return max(1, round(cost_ns * self.scale))
