"""The master's end of one serial line.  It is passive: its creator provides the clock and transports the bytes.

Source: Modbus over serial line V1.02, 2.4.1: a response of another server than the one that was asked is ignored, and
so is a response that cannot answer the request.  `line_model` ensures that one exchange is open at a time, and has the
duration of a request and the response timeout.
"""

from collections.abc import Callable
from typing import Any

from fieldrig.clock import Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.framing import LineFramer
from fieldrig_bus.modbus.message import BROADCAST, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.responses import fits


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
        return self._framer.ahead

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
