"""The number of instructions that the user's program may execute between two control loops.

Source: manual 3.1, @Par[01] and @Par[16]; digest chapter 11.  The manual gives no execution times; it only says that a
longer control period and a longer scheduler period leave more time to the program.  So every control loop, scheduler
pass and instruction costs a fixed time, which is a setting, and the rest of a control period is the program's.
"""

from collections.abc import Callable

from pydantic import Field

from fieldrig.clock import US
from fieldrig.settings import Settings


class Costs(Settings):
    instruction_us: int = Field(default=50, ge=1, description="processor time of one instruction")
    control_us: int = Field(default=300, ge=0, description="processor time of one control loop, every @Par[1]")
    scheduler_us: int = Field(default=1_000, ge=0, description="processor time of one scheduler pass, every @Par[16]")


class Slices:
    """Shares out processor time.  Nothing is lost to rounding: unused time and overruns of a slice are carried over."""

    def __init__(self, costs: Costs, control_period_ns: int, scheduler_period_ns: int) -> None:
        self._instruction_ns = costs.instruction_us * US
        scheduler_ns = costs.scheduler_us * US * control_period_ns // scheduler_period_ns
        self.earned_ns = max(control_period_ns - costs.control_us * US - scheduler_ns, 0)
        """Time that a control period leaves to the program; if it is 0, the program does not run."""
        self._balance_ns = 0

    def give(self, run: Callable[[int], int]) -> None:
        """Run the slice after one control loop: `run` is called with its budget in instructions and returns what is
        left of it.

        There is no slice while the overrun of an earlier one is paid off.  A waiting program does not save up time.
        """
        self._balance_ns += self.earned_ns
        budget = self._balance_ns // self._instruction_ns
        if budget > 0:
            self._balance_ns -= (budget - min(run(budget), 0)) * self._instruction_ns
