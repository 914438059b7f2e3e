"""The card's side of the operator terminal: what MSG, TERM and PRINT ask for, the keys and LEDs, the values on the screen.

Source: manual 4.5 and 5.12; digest chapters 8.1 and 16.
"""

from collections.abc import Callable

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.arp.faults import Faults
from fieldrig_devices.arp.readings import Readings
from fieldrig_devices.arp.runtime.card import Shown


class TerminalLink:
    """Instructions only ask: they are carried out in their order, as fast as the terminal takes them."""

    def __init__(
        self,
        clock: Clock,
        can: Link[CanFrame] | None,
        variables: list[int],
        flags: list[int],
        faults: Faults,
        set_variable: Callable[[int, int], None],
        readings: Readings | None = None,
    ) -> None:
        """`set_variable` gets the number of a V and the raw value that the operator has given it.

        Without `can` no terminal is configured.
        """
        raise NotImplementedError

    def start(self, node_id: int | None) -> None:
        """Power-on.  None: no terminal is configured, F218 to F256 are the program's, and instructions are E06."""
        raise NotImplementedError

    def refresh(self) -> None:
        """Every pass of the scheduler: F225 to F256 from the keys, LEDs, instructions that wait, values that changed."""
        raise NotImplementedError

    def release(self) -> None:
        """The program was reset: what it asked for and was not carried out yet is forgotten, but for messages."""
        raise NotImplementedError

    def store_message(self, number: int, text: str) -> None:
        raise NotImplementedError

    def clear_screen(self) -> None:
        raise NotImplementedError

    def erase_text(self, line: int, column: int) -> None:
        raise NotImplementedError

    def show_text(self, shown: Shown) -> None:
        raise NotImplementedError

    def print_text(self, message: int, variable: int | None) -> None:
        raise NotImplementedError
