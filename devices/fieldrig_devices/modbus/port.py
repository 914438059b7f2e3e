"""The units of a device at one of its Modbus buses: a request takes effect on arrival; its response leaves later."""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

from pydantic import Field

from fieldrig.clock import MS, Clock
from fieldrig.link import Link
from fieldrig.settings import Settings
from fieldrig_bus.modbus.message import BROADCAST, ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.modbus.server import ModbusServer
from fieldrig_devices.modbus.answer_times import Answer

Turnaround = int | Callable[[ModbusRequest], Answer]
"""The time of all responses in nanoseconds, or what returns the answer to a request."""
UnitId = Annotated[int, Field(ge=1, le=247, description="unit id (slave address)")]


class TurnaroundSettings(Settings):
    """Settings of every device that is a Modbus server."""

    turnaround_ms: float = Field(
        default=2.0, ge=0, le=60_000, description="time from a request to its response; 0: immediately"
    )

    @property
    def turnaround_ns(self) -> int:
        """Time from a request to its response, in nanoseconds."""
        return round(self.turnaround_ms * MS)


class PortSettings(TurnaroundSettings):
    """Settings of a device that is one unit."""

    unit_id: UnitId = 1


class ModbusPort:
    """The owner of the link passes messages to `on_message`; `servers`, by unit id, may be replaced at any time."""

    def __init__(
        self,
        clock: Clock,
        link: Link[Any],
        servers: Mapping[int, ModbusServer],
        turnaround_ns: Turnaround,
        on_done: Callable[[], None] = lambda: None,
    ) -> None:
        """`on_done` is called after a request has taken effect and before its response leaves.

        A request is lost or refused if that is what `turnaround_ns` returns for it.
        """
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
        self.respond(request, server.answer)

    def respond(self, request: ModbusRequest, answer: Callable[[ModbusRequest], bytes | None]) -> None:
        """Send what `answer` returns for a request after the time that it takes."""
        takes = self._turnaround_ns
        takes_ns, exception = (takes, 0) if isinstance(takes, int) else takes(request)
        if takes_ns is None:
            return
        pdu = bytes((request.pdu[0] | 0x80, exception)) if exception else answer(request)
        self._on_done()
        if pdu is None:
            return
        response = ModbusResponse(request.unit, pdu, request.exchange)
        if takes_ns == 0:
            self._send(response)
        else:
            self._clock.call_at(self._clock.now_ns() + takes_ns, lambda: self._send(response))
