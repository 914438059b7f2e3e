"""The faults that a node has at present: its error word, and a message for each beginning and end.

Source: Table 12-2 for the word, appendix B.6 for the messages 04..00C, 00E and 010.  A command that was wrong is over
at once, so its warning ends by itself; how long it lasts is ours.
"""

from collections.abc import Callable, Mapping
from enum import IntEnum
from typing import Final

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.pamring.frames import Severity, Trouble

NODE, OUTPUT, MOTOR = 0x00C, 0x00E, 0x010
"""Numbers of the messages."""
EVENT_NS: Final = S
"""How long the warning of a single event lasts after the last one of its kind."""


class FaultCode(IntEnum):
    """Code of a fault."""

    HEAP = 0x01
    FIFO = 0x02
    CRC = 0x03
    FRAME_TYPE = 0x04
    SHORT_CIRCUIT = 0x05
    HEAT_SINK = 0x06
    TIMEOUT = 0x07
    AMBIENT = 0x08
    UNKNOWN_COMMAND = 0x09
    COMMAND_NOT_ALLOWED = 0x0A
    UNDECLARED_ITEM = 0x0B
    UNKNOWN_TYPE = 0x0C
    LOWER_LIMIT = 0x0D
    UPPER_LIMIT = 0x0E
    POSITION_LOST = 0x0F
    UNEXPECTED_MOVE = 0x10
    DOES_NOT_STOP = 0x11


NODE_BITS: Final[Mapping[FaultCode, int]] = {
    FaultCode.HEAP: 0x00_0001,
    FaultCode.FIFO: 0x00_0002,
    FaultCode.CRC: 0x00_0004,
    FaultCode.FRAME_TYPE: 0x00_0008,
    FaultCode.AMBIENT: 0x00_1000,
    FaultCode.POSITION_LOST: 0x00_2000,
    FaultCode.UNEXPECTED_MOVE: 0x00_4000,
    FaultCode.DOES_NOT_STOP: 0x00_8000,  # blank in the table (E-28)
    FaultCode.UNKNOWN_COMMAND: 0x01_0000,
    FaultCode.COMMAND_NOT_ALLOWED: 0x02_0000,
    FaultCode.UNDECLARED_ITEM: 0x04_0000,
    FaultCode.UNKNOWN_TYPE: 0x08_0000,
}
"""Table 12-2.  The heat sinks of modules 1 to 8 have the bits from 0x10 on; a short circuit has none."""
MODULES_WITH_BIT: Final = 8
MOTOR_BITS: Final[Mapping[FaultCode, int]] = {
    FaultCode.TIMEOUT: 0x00_0001,
    FaultCode.LOWER_LIMIT: 0x00_0002,
    FaultCode.UPPER_LIMIT: 0x00_0004,
    FaultCode.POSITION_LOST: 0x00_2000,
    FaultCode.UNEXPECTED_MOVE: 0x00_4000,
    FaultCode.DOES_NOT_STOP: 0x00_8000,
}
"""Table 12-3."""


def heat_sink_bit(module: int) -> int:
    return 0x10 << (module - 1) if module <= MODULES_WITH_BIT else 0


def output_detail(module: int, group: int) -> int:
    """D2 of a message 04..00E; group 0 is the heat sink of the module."""
    return module * 0x1_0000 + group


Key = tuple[int, int, int]
"""A message with its D2 and D3."""


class Troubles:
    """The present faults, by their messages."""

    def __init__(self, clock: Clock, tell: Callable[[Trouble], None]) -> None:
        self._clock, self._tell = clock, tell
        self._present: dict[Key, int] = {}
        self._ends: dict[Key, Alarm] = {}
        """When the warnings of single events end."""

    @property
    def word(self) -> int:
        """The error word of the node."""
        word = 0
        for bits in self._present.values():
            word |= bits
        return word

    def begin(self, code: int, details: tuple[int, int], bits: int) -> None:
        """Report a fault, unless it is there already."""
        key = (code, *details)
        if key not in self._present:
            self._present[key] = bits
            self._tell(Trouble(Severity.WARNING, code, details, self.word))

    def end(self, code: int, details: tuple[int, int]) -> None:
        """Report the end of a fault, if it was there."""
        if self._present.pop((code, *details), None) is not None:
            self._tell(Trouble(Severity.ENDED, code, details, self.word))

    def set(self, is_there: bool, code: int, details: tuple[int, int], bits: int) -> None:
        if is_there:
            self.begin(code, details, bits)
        else:
            self.end(code, details)

    def event(self, fault: FaultCode, detail: int = 0) -> None:
        """Report a single event of the node, whose warning ends by itself."""
        details = (int(fault), detail)
        key = (NODE, *details)
        self.begin(NODE, details, NODE_BITS[fault])
        self._ends.setdefault(key, Alarm(self._clock)).after(EVENT_NS, lambda: self._end_event(details))

    def _end_event(self, details: tuple[int, int]) -> None:
        del self._ends[NODE, *details]
        self.end(NODE, details)

    def forget(self) -> None:
        """Drop what only commands and items had caused, without a message, as the PAM begins again."""
        for key, alarm in self._ends.items():
            alarm.stop()
            del self._present[key]
        self._ends.clear()
        self._present = {
            key: bits for key, bits in self._present.items() if key[0] != MOTOR and key[:2] != (NODE, FaultCode.HEAP)
        }

    def repeat(self) -> None:
        """Report all present faults to a PAM that does not know them yet."""
        for code, *details in self._present:
            self._tell(Trouble(Severity.WARNING, code, (details[0], details[1]), self.word))
