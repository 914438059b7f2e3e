"""The card's errors and warnings: the most recent of each, until they are cleared.

Source: manual 4.0 (error codes); digest chapter 10.  Reading a code does not clear it; opening and closing Enable does,
and the reset from the service port.
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


class Faults:
    def __init__(self, on_blocking: Callable[[int], None]) -> None:
        """`on_blocking` is called with a code that stops the program."""
        self._on_blocking = on_blocking
        self.error = 0
        self.warning = 0
        self.error_axis = 0
        """Which axis the error is about; 0: none (digest I-45)."""

    def fail(self, code: int, axis: int = 0) -> None:
        """103 to 116.  While Enable is low that is the error, and only one that blocks takes its place."""
        if self.error == RESET and code not in BLOCKING:
            return
        self.error, self.error_axis = code, axis
        if code in BLOCKING:
            self._on_blocking(code)

    def warn(self, code: int) -> None:
        """201 to 204."""
        self.warning = code

    def clear(self) -> None:
        self.error = self.error_axis = self.warning = 0
