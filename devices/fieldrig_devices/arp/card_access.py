"""External access to a card, through the service port and CAN, and the rules for it.

Source: digest chapters 10 and 17.  Values are raw integers.  Nothing here raises for data from a bus, apart from
`load`; a request that is not allowed returns False.
"""

from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from enum import IntEnum
from typing import NamedTuple, Protocol

from fieldrig.loop.background import Job
from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.language.files import ObjectError
from fieldrig_devices.arp.parameters import Parameters, ParameterValues
from fieldrig_devices.arp.runtime.program import ArpProgram


class CardState(IntEnum):
    """State of the card (digest 10.1).  The numbers are ours; the service port and CAN report them."""

    INIT = 0
    RESET_ENABLE = 1  # Enable is low
    RESET_COMMAND = 2  # Ctrl-F2
    RUN = 3
    STOPPED = 4
    BLOCKED = 5


class RefusedError(Exception):
    """A request that is not possible now.  The message gives the reason and the remedy."""


OnLoaded = Callable[[RefusedError | ObjectError | None], None]
"""Called with the reason why a program was not loaded, or None if it is loaded."""


class Progress(NamedTuple):
    """How far the card is with the program that it loads."""

    what: str
    done: int
    steps: int

    @property
    def percent(self) -> int:
        return 100 * self.done // max(self.steps, 1)


class CardAccess(Protocol):
    number: int
    """Communication address of the system, nn: 0 to 99."""
    V: list[int]
    F: list[int]
    I: list[int]  # noqa: E741  the manual's letter
    O: list[int]  # noqa: E741
    parameters: Parameters
    errors: CardErrors

    @property
    def state(self) -> CardState: ...
    @property
    def program(self) -> ArpProgram | None: ...
    @property
    def program_name(self) -> str: ...
    @property
    def program_object(self) -> bytes:
        """The object file of the program, in canonical form; empty without a program."""

    @property
    def loading(self) -> Progress | None:
        """The progress of the program that is being loaded; None if there is none."""

    def position(self, axis: int) -> int: ...
    def speed(self, axis: int) -> int: ...
    def tracking_error(self, axis: int) -> int:
        """Reference minus reading."""

    def analog_input(self, channel: int) -> int:
        """Value of ADC 1 to 6, in the scale that programs use."""

    def analog_output(self, channel: int) -> int:
        """Value of DAC 1 or 2, in thousandths of a volt."""

    def set_variables(self, first: int, values: Sequence[int]) -> bool:
        """Write V`first` and the variables after it, raw.  All of them are written, or none."""

    def set_flag(self, number: int, bit: int) -> bool:
        """Write a flag.  Only R/W flags may be written."""

    def set_output(self, number: int, bit: int) -> bool:
        """Write an output, O101 to O332.  False while the card holds its outputs at 0."""

    def set_parameter(self, group: int, number: int, raw: int) -> bool:
        """Write the copy in RAM.  A general parameter that is read only at the start applies from the next start."""

    def save_parameter(self, group: int, number: int, raw: int) -> bool:
        """Write the copies in flash and in RAM."""

    def save_parameters(self, values: ParameterValues) -> bool:
        """Write copies in flash in one step: all of them or none.  An empty mapping writes nothing."""

    def saving(self, values: ParameterValues) -> AbstractContextManager[None]:
        """Write copies in flash in the same step as the node's own data in the `with` block; if it fails, none are
        written."""

    def run_program(self) -> bool:
        """Run the program: from its first instruction after a reset command, a stop or its end; on from a pause."""

    def stop_program(self) -> bool: ...
    def reset(self) -> None:
        """Reset the card, as Ctrl-F2 does."""

    def load(self, data: bytes, on_loaded: OnLoaded) -> Job:
        """Compile a program, an object file, beside the running card; then put it into permanent memory, held at its
        first instruction.

        The program is refused with RefusedError if one runs, now or then, and with ObjectError for data that are not
        an object or are for another card.  Either way the old program is kept, as it is if the job is cancelled.
        """
