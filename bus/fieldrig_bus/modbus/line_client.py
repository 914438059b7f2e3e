"""The master's end of one serial line.  It is passive: its creator provides the clock and transports the bytes.

Source: Modbus over serial line V1.02, 2.4.1: a response of another server than the one that was asked is ignored, and
so is a response that cannot answer the request.  `line_model` ensures that one exchange is open at a time, and has the
duration of a request and the response timeout.
"""

from collections.abc import Callable
from typing import Any, Final

from fieldrig.clock import Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.framing import LineFramer
from fieldrig_bus.modbus.message import BROADCAST, ModbusRequest, ModbusResponse

EXCEPTION: Final = 0x80
EXCEPTION_SIZE: Final = 2

BITS_READ: Final = frozenset({1, 2})
REGISTERS_READ: Final = frozenset({3, 4})
ECHOED: Final = {5: 5, 6: 5, 15: 5, 16: 5, 22: 7}
"""Number of bytes of the request that the response to a write repeats."""
READ_WRITE: Final = 23
READ_HEAD: Final = 5


def fits(request: bytes, response: bytes) -> bool:
    """True if the PDU of a response matches that of a request: by function code, and by size or echo where possible.

    Source: Modbus application protocol V1.1b3, chapter 6, and chapter 7 for exceptions.  A serial line has no
    transaction numbers, so only the contents distinguish a late response from the right one.
    """
    function = request[0]
    if response[0] == function | EXCEPTION:
        return len(response) == EXCEPTION_SIZE
    if response[0] != function:
        return False
    if (echoed := ECHOED.get(function)) is not None:
        return response == request[:echoed]
    size = _size(request)
    return size is None or (len(response) == 2 + size and response[1] == size)


def _size(request: bytes) -> int | None:
    """The size of the requested data, in bytes."""
    function, quantity = request[0], int.from_bytes(request[3:5], "big")
    if len(request) < READ_HEAD:
        return None
    if function in BITS_READ:
        return (quantity + 7) // 8
    return 2 * quantity if function in REGISTERS_READ or function == READ_WRITE else None


class LineClient:
    """Turns requests into bytes, and received bytes into responses."""

    def __init__(
        self, clock: Clock, link: Link[Any], write: Callable[[bytes], None], framer: LineFramer, units: list[int]
    ) -> None:
        self._clock, self._link, self._write, self._framer = clock, link, write, framer
        self._asked: ModbusRequest | None = None
        self._wake = Alarm(self._clock)
        self.foreign = 0
        """Number of responses without a matching request."""
        link.on_receive(self._on_request, units)

    def on_bytes(self, data: bytes) -> None:
        self._framer.feed(self._clock.now_ns(), data)
        self._take()

    def close(self) -> None:
        self._wake.stop()

    @property
    def ahead(self) -> int:
        return self._framer.ahead(self._clock.now_ns())

    def _on_request(self, request: ModbusRequest) -> None:
        self._asked = None if request.unit == BROADCAST else request
        self._write(self._framer.frame(request.unit, request.pdu))

    def _take(self) -> None:
        for unit, pdu in self._framer.take(self._clock.now_ns()):
            self._on_response(unit, pdu)
        self.close()
        next_ns = self._framer.next_ns()
        self._wake.at(next_ns, self._take)

    def _on_response(self, unit: int, pdu: bytes) -> None:
        asked = self._asked
        if asked is None or unit != asked.unit or not fits(asked.pdu, pdu):
            self.foreign += 1
            return
        self._asked = None
        self._link.send(ModbusResponse(unit, pdu, asked.exchange))
