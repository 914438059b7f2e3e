"""The errors and warnings of an ARP card: the most recent code of each is kept until it is cleared.

Source: manual 4.0 (error codes); digest chapter 10.  Reading a code does not clear it.  Opening and closing Enable
clears it, and so does a reset from the service port.
"""

from collections.abc import Callable
from typing import Final

EEPROM: Final = 103  # E03
RESET: Final = 105  # E05: Enable is low
CAN: Final = 106  # E06
STOPPED_PROGRAM: Final = 111  # E11
STACK: Final = 112  # E12
PARAMETERS: Final = 113  # E13
CONTROL_LOSS: Final = 116  # E16
BLOCKING: Final = frozenset({EEPROM, RESET, STOPPED_PROGRAM, STACK})


class CardErrors:
    """The error and the warning that an ARP card shows.  They are not the faults that a test injects."""

    def __init__(self, on_blocking: Callable[[int], None]) -> None:
        """`on_blocking` is called with a code that stops the program."""
        self._on_blocking = on_blocking
        self.error = 0
        self.warning = 0
        self.error_axis = 0
        """The axis of the error; 0 if it belongs to no axis (digest I-45)."""

    def fail(self, code: int, axis: int = 0) -> None:
        """Set the error, 103 to 116.  While Enable is low, only a blocking error replaces error 105."""
        if self.error == RESET and code not in BLOCKING:
            return
        self.error, self.error_axis = code, axis
        if code in BLOCKING:
            self._on_blocking(code)

    def warn(self, code: int) -> None:
        """Set the warning, 201 to 204."""
        self.warning = code

    def clear(self) -> None:
        """Reset error and warning to 0."""
        self.error = self.error_axis = self.warning = 0
