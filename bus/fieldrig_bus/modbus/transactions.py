"""A client's end of one TCP connection: requests out, responses in, matched by their transaction numbers.

Source: Modbus messaging on TCP/IP implementation guide V1.0b, 4.4.1: a response whose number refers to no pending
transaction is discarded; the unit of one that a server gives itself (255, as 0) is not significant, another one has to
be that of the request.  What the PDU says is for the client to judge.
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
    """As it was asked."""
    deadline_ns: int


class Transactions:
    def __init__(self, timeout_ns: int) -> None:
        self._timeout_ns = timeout_ns
        self._number = 0
        self._pending: dict[int, _Pending] = {}  # in the order of their deadlines
        self._framer = MbapFramer()
        self.foreign = 0
        """Responses that belonged to nothing."""

    @property
    def is_full(self) -> bool:
        return len(self._pending) >= MOST_PENDING

    @property
    def is_lost(self) -> bool:
        """What comes in is no Modbus: the connection has to be closed."""
        return self._framer.is_lost

    def ask(self, now_ns: int, request: ModbusRequest, unit: int) -> bytes:
        """What to send for a request that goes to `unit`."""
        self._number = number = (self._number + 1) % _NUMBERS
        self._pending.pop(number, None)
        self._pending[number] = _Pending(request, unit, now_ns + self._timeout_ns)
        return tcp_frame(number, unit, request.pdu)

    def feed(self, data: bytes) -> list[ModbusResponse]:
        """The responses that are whole with `data`, as those who asked want them."""
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
        """When `expire` should be called next."""
        return next((pending.deadline_ns for pending in self._pending.values()), None)

    def expire(self, now_ns: int) -> int:
        """Forget what has waited too long; how many there were."""
        late = [number for number, pending in self._pending.items() if pending.deadline_ns <= now_ns]
        for number in late:
            del self._pending[number]
        return len(late)
