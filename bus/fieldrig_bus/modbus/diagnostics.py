"""Function 8: the diagnostics of a server's serial port, and listen only mode.

Source: Modbus application protocol V1.1b3, 6.8, and Modbus over serial line V1.02, 4 (the counters).  Negative
acknowledge, busy and overrun never occur here, so their counters are 0.  On TCP there is no port that could be silenced
or get another delimiter, so sub-functions 3 and 4 are refused (01); sub-function 3 exists on ASCII only.
"""

from collections.abc import Callable
from typing import Final

from fieldrig_bus.modbus.errors import ILLEGAL_DATA_VALUE, ILLEGAL_FUNCTION, ModbusError
from fieldrig_bus.modbus.event_log import EventLog
from fieldrig_bus.modbus.message import LineState

QUERY_DATA, RESTART, REGISTER, DELIMITER, LISTEN_ONLY, CLEAR, CLEAR_OVERRUN = 0, 1, 2, 3, 4, 0x0A, 0x14

CLEAR_LOG: Final = b"\xff\x00"
KEEP_LOG: Final = b"\x00\x00"
NO_LINE: Final = LineState()
_THEMSELVES: Final = (RESTART.to_bytes(2, "big"), LISTEN_ONLY.to_bytes(2, "big"))
"""Sub-functions that are events of their own."""


class Diagnostics:
    """Counters since the last restart, clear, or power-up."""

    def __init__(self) -> None:
        self.server_messages = 0
        """Messages addressed to this unit or broadcast, including the one that is being answered."""
        self.no_responses = 0
        self.exception_responses = 0
        self.is_listening_only = False
        self.line: LineState | None = None
        """The state of the line that came with the request that is being answered."""
        self.events = EventLog()
        self._since = NO_LINE
        self._errors = 0
        """The errors of the line up to the last message."""
        self._counters: dict[int, Callable[[], int]] = {
            REGISTER: lambda: 0,  # no contents are defined
            0x0B: self._bus_messages,
            0x0C: lambda: (self.line or NO_LINE).errors - self._since.errors,
            0x0D: lambda: self.exception_responses,
            0x0E: lambda: self.server_messages,
            0x0F: lambda: self.no_responses,
            0x10: lambda: 0,  # negative acknowledges
            0x11: lambda: 0,  # busy
            0x12: lambda: 0,  # overruns
        }

    def receive(self, is_broadcast: bool, line: LineState) -> None:
        """Note a message of a serial line in the log of events."""
        self.events.receive(is_broadcast, line.errors > self._errors, self.is_listening_only)
        self._errors = line.errors

    def send(self, pdu: bytes, exception: int) -> None:
        """Note that a message has been executed; a restart or listen only mode has noted itself."""
        if exception == 0 and pdu[0] == 8 and pdu[1:3] in _THEMSELVES:
            return
        self.events.send(pdu[0], exception, self.is_listening_only)

    def answer(self, pdu: bytes) -> bytes | None:
        """The response to function 8; None for `force listen only mode`, which is not answered."""
        if len(pdu) < 3:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        line = self.line
        function, data = int.from_bytes(pdu[1:3], "big"), pdu[3:]
        counter = self._counters.get(function)
        if counter is not None:
            _check(data == b"\x00\x00")
            return pdu[:3] + (counter() & 0xFFFF).to_bytes(2, "big")
        if function == QUERY_DATA:
            _check(len(data) > 0 and len(data) % 2 == 0)
        elif function == RESTART:
            _check(data in (KEEP_LOG, CLEAR_LOG))
            self._clear()
            self.events.restart(data == CLEAR_LOG)
        elif function == DELIMITER and line is not None and line.is_ascii:
            _check(len(data) == 2 and data[0] < 0x80 and data[1] == 0)
        elif function == LISTEN_ONLY and line is not None:
            _check(data == b"\x00\x00")
            self.is_listening_only = True
            self.no_responses += 1
            self.events.enter_listen_only()
            return None
        elif function in (CLEAR, CLEAR_OVERRUN):
            _check(data == b"\x00\x00")
            if function == CLEAR:
                self._clear()
                self.events.clear_counter()
        else:
            raise ModbusError(ILLEGAL_FUNCTION)
        return pdu

    def hear_in_listen_only(self, pdu: bytes) -> None:
        """Listen only mode: the only request that is executed is `restart communications` (6.8.1, sub-function 1)."""
        self.no_responses += 1
        if pdu in (b"\x08\x00\x01" + KEEP_LOG, b"\x08\x00\x01" + CLEAR_LOG):
            self.is_listening_only = False
            self._clear()
            self.events.restart(pdu.endswith(CLEAR_LOG))

    def _bus_messages(self) -> int:
        return self.server_messages if self.line is None else self.line.messages - self._since.messages

    def _clear(self) -> None:
        self.server_messages = self.no_responses = self.exception_responses = 0
        self._since = self.line or NO_LINE


def _check(is_right: bool) -> None:
    if not is_right:
        raise ModbusError(ILLEGAL_DATA_VALUE)
