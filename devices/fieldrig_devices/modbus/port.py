"""Units of a device at one of its Modbus buses: a request takes effect when it arrives, its response leaves later."""

from collections.abc import Callable, Mapping
from typing import Any

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.modbus.message import BROADCAST, ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.server import ModbusServer


class ModbusPort:
    """`on_message` is for whoever listens to the link; `servers`, by unit ids, may be replaced at any time."""

    def __init__(
        self,
        clock: Clock,
        link: Link[Any],
        servers: Mapping[int, ModbusServer],
        turnaround_ns: int,
        on_done: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_done` is called when a request has taken effect, before its response leaves."""
        self._clock, self.servers, self._on_done = clock, servers, on_done
        self._send, self._turnaround_ns = link.send, turnaround_ns

    def on_message(self, request: ModbusMessage) -> None:
        if not isinstance(request, ModbusRequest):
            return
        server = self.servers.get(request.unit)
        if server is None:
            if request.unit == BROADCAST:
                for server in self.servers.values():
                    server.answer(request)
                self._on_done()
            return
        pdu = server.answer(request)
        self._on_done()
        if pdu is None:
            return
        response = ModbusResponse(request.unit, pdu, request.exchange)
        if self._turnaround_ns == 0:
            self._send(response)
        else:
            self._clock.call_at(self._clock.now_ns() + self._turnaround_ns, lambda: self._send(response))
