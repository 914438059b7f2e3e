"""The cost of a program in processor time and in memory: a stated model, because the manual gives no figures.

Every operation that the source asks for costs a fixed time, whatever Python makes of it; a library function has its own
cost (`library/overload.py`, `host.py`).  The defaults are the orders of magnitude of a controller of 2003.  They are
keys of a controller in the rig file, for calibration: `scale` is the load of a program on a machine divided by its load
here, and the other keys are for programs that do mostly one kind of operation.
"""

from typing import Final

from pydantic import Field

from fieldrig.settings import Settings

CODE_PER_NS: Final = 0.2
"""Bytes of machine code for a nanosecond of cost: 4 to 5 bytes for an instruction of 20 ns."""
CODE_PER_ROUTINE: Final = 32
"""Bytes of entry and exit code."""
MOST_NS: Final = 1_000_000


class Costs(Settings):
    """Processor time by kind of operation."""

    access_ns: int = Field(
        default=20, ge=0, le=MOST_NS, description="reading or writing a variable, and each index or pointer on the way"
    )
    operation_ns: int = Field(
        default=20, ge=0, le=MOST_NS, description="an operation on integers, bits or times, and a comparison"
    )
    multiply_ns: int = Field(default=30, ge=0, le=MOST_NS, description="a multiplication of integers")
    divide_ns: int = Field(default=150, ge=0, le=MOST_NS, description="a division of integers, and MOD")
    real_ns: int = Field(default=60, ge=0, le=MOST_NS, description="an operation on REAL or LREAL")
    text_ns: int = Field(default=500, ge=0, le=MOST_NS, description="copying or comparing a string")
    copy_ns: int = Field(default=2, ge=0, le=MOST_NS, description="copying a byte of a structure or array")
    jump_ns: int = Field(default=20, ge=0, le=MOST_NS, description="a branch: IF, CASE, each pass of a loop")
    call_ns: int = Field(default=200, ge=0, le=MOST_NS, description="a call of a function, block or action")
    end_ns: int = Field(default=100, ge=0, le=MOST_NS, description="the end of a unit")
    parameter_ns: int = Field(
        default=2_000, ge=0, le=MOST_NS, description="access to a parameter of a configuration object"
    )
    io_ns: int = Field(default=500, ge=0, le=MOST_NS, description="access to %I or %Q, which goes to the terminals")
    scale: float = Field(
        default=1.0, ge=0.001, le=1_000, description="factor for all of these, and for library functions"
    )

    def scaled(self, cost_ns: int) -> int:
        """Return a cost for this controller; at least 1, so that every loop takes time."""
        return max(1, round(cost_ns * self.scale))
