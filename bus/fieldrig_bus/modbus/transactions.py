"""A client's end of one TCP connection: it matches responses with requests by their transaction numbers.

Source: Modbus messaging on TCP/IP implementation guide V1.0b, 4.4.1: a response whose number refers to no pending
transaction is discarded; the unit is not significant for a request to the server itself (unit 255 or 0), and must
otherwise be that of the request.  The client checks the PDU.
"""

from dataclasses import dataclass
from typing import Final

from fieldrig_bus.modbus.framing_mbap import MbapFramer, tcp_frame
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.routing import NOT_SIGNIFICANT

MOST_PENDING: Final = 16
"""Transactions of one client at one server (guide, 4.4.1, NumberMaxOfClientTransaction: 1 to 16)."""
_NUMBERS: Final = 0x1_0000


@dataclass(frozen=True, slots=True)
class _Pending:
    request: ModbusRequest
    unit: int
    """The request as the client sent it."""
    deadline_ns: int


class Transactions:
    def __init__(self, timeout_ns: int) -> None:
        self._timeout_ns = timeout_ns
        self._number = 0
        self._pending: dict[int, _Pending] = {}  # by deadline
        self._framer = MbapFramer()
        self.foreign = 0
        """Number of responses without a matching request."""

    @property
    def is_full(self) -> bool:
        return len(self._pending) >= MOST_PENDING

    @property
    def is_lost(self) -> bool:
        """True if the received bytes are not Modbus: the connection has to be closed."""
        return self._framer.is_lost

    def ask(self, now_ns: int, request: ModbusRequest, unit: int) -> bytes:
        """The bytes to send for a request to `unit`."""
        self._number = number = (self._number + 1) % _NUMBERS
        self._pending.pop(number, None)
        self._pending[number] = _Pending(request, unit, now_ns + self._timeout_ns)
        return tcp_frame(number, unit, request.pdu)

    def feed(self, data: bytes) -> list[ModbusResponse]:
        """The responses that `data` completes, with the unit and exchange of their requests."""
        responses = []
        for number, unit, pdu in self._framer.feed(data):
            pending = self._pending.get(number)
            if pending is None or (unit != pending.unit and unit not in NOT_SIGNIFICANT):
                self.foreign += 1
                continue
            del self._pending[number]
            responses.append(ModbusResponse(pending.request.unit, pdu, pending.request.exchange))
        return responses

    def next_ns(self) -> int | None:
        """The instant at which `expire` should be called next."""
        return next((pending.deadline_ns for pending in self._pending.values()), None)

    def expire(self, now_ns: int) -> int:
        """Drop requests past their deadline.  Returns their number."""
        late = [number for number, pending in self._pending.items() if pending.deadline_ns <= now_ns]
        for number in late:
            del self._pending[number]
        return len(late)
