"""How many instructions the user's program may run between two control loops.

Source: manual 3.1, @Par[01] and @Par[16]; digest chapter 11.  The manual gives no execution times, only that a longer
control period and a longer scheduler period leave more time to the program; so every control loop, scheduler pass and
instruction costs a fixed time, all of them settings, and what a control period leaves over is the program's.
"""

from collections.abc import Callable

from pydantic import Field

from fieldrig.clock import US
from fieldrig.settings import Settings


class Costs(Settings):
    instruction_us: int = Field(default=50, ge=1, description="of the processor's time, for one instruction")
    control_us: int = Field(default=300, ge=0, description="for one control loop, every @Par[1]")
    scheduler_us: int = Field(default=1_000, ge=0, description="for one pass of the scheduler, every @Par[16]")


class Slices:
    """Time is never lost to rounding: what is too short for an instruction, and what a slice ran over, is carried."""

    def __init__(self, costs: Costs, control_period_ns: int, scheduler_period_ns: int) -> None:
        self._instruction_ns = costs.instruction_us * US
        scheduler_ns = costs.scheduler_us * US * control_period_ns // scheduler_period_ns
        self.earned_ns = max(control_period_ns - costs.control_us * US - scheduler_ns, 0)
        """What a control period leaves to the program; with 0 it doesn't run."""
        self._balance_ns = 0

    def give(self, run: Callable[[int], int]) -> None:
        """The slice after one control loop: `run` gets its budget in instructions, and returns what is left of it.

        While the last slice is still paid off there is none; a program that waits doesn't save up time.
        """
        self._balance_ns += self.earned_ns
        budget = self._balance_ns // self._instruction_ns
        if budget > 0:
            self._balance_ns -= (budget - min(run(budget), 0)) * self._instruction_ns
