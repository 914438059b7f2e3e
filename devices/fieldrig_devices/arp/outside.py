"""What of the card may be reached from outside, by the service port and by CAN, and under which rules.

Source: digest chapters 10 and 17.  Values are raw integers.  Nothing here raises for what comes from a bus, but for
`load`; what is not allowed is refused with False.
"""

from collections.abc import Sequence
from contextlib import AbstractContextManager
from enum import IntEnum
from typing import Protocol

from fieldrig_devices.arp.card_errors import CardErrors
from fieldrig_devices.arp.parameters import Parameters, ParameterValues
from fieldrig_devices.arp.runtime.program import ArpProgram


class CardState(IntEnum):
    """Digest 10.1; the numbers are ours, and are what the service port and CAN tell."""

    INIT = 0
    RESET_ENABLE = 1  # Enable is low
    RESET_COMMAND = 2  # Ctrl-F2
    RUN = 3
    STOPPED = 4
    BLOCKED = 5


class RefusedError(Exception):
    """What was asked can't be done now; the message says why and what to do."""


class Outside(Protocol):
    number: int
    """The system's communication address, nn: 0 to 99."""
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

    def position(self, axis: int) -> int: ...
    def speed(self, axis: int) -> int: ...
    def tracking_error(self, axis: int) -> int:
        """Reference less reading."""

    def analog_input(self, channel: int) -> int:
        """ADC 1 to 6, in the scale of the program."""

    def analog_output(self, channel: int) -> int:
        """DAC 1 or 2: thousandths of a volt."""

    def set_variables(self, first: int, values: Sequence[int]) -> bool:
        """V`first` and those after it, raw; all or none."""

    def set_flag(self, number: int, bit: int) -> bool:
        """Only those that are R/W."""

    def set_output(self, number: int, bit: int) -> bool:
        """O101 to O332.  Refused while the card holds its outputs at 0."""

    def set_parameter(self, group: int, number: int, raw: int) -> bool:
        """The copy in RAM.  A general parameter that is only read at the start counts from the next start on."""

    def save_parameter(self, group: int, number: int, raw: int) -> bool:
        """The copies in flash and in RAM."""

    def save_parameters(self, values: ParameterValues) -> bool:
        """The copies in flash, in one step: all or none.  Nothing is written if there are none."""

    def saving(self, values: ParameterValues) -> AbstractContextManager[None]:
        """The copies in flash, with what the node writes within, in the same step; none if that fails."""

    def run_program(self) -> bool:
        """After the reset command, a stop, or its end: from the first instruction; after a pause it goes on."""

    def stop_program(self) -> bool: ...
    def reset(self) -> None:
        """Ctrl-F2."""

    def load(self, data: bytes) -> None:
        """Put a program, an object file, into permanent memory; it is held at its first instruction.

        RefusedError while the program runs; ObjectError for what is no object, or one for another card.  Either way
        the old program stays as it was.
        """
