"""A Modbus medium without delay: TCP, or a line whose port takes the time itself.

A request for a unit that no server has is answered as by a gateway (exception 0x0B), or not at all; see `unknown_unit`
of `modbus.tcp`.
"""

from bisect import insort
from collections.abc import Collection, Sequence
from operator import attrgetter
from typing import Any

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.modbus.framing import Mode
from fieldrig_bus.modbus.message import Asked, ClientConnected, LineState, ModbusRequest, ModbusResponse, OnModbus
from fieldrig_bus.modbus.routing import Routing

GATEWAY = "gateway"
"""The sender, in traces, of answers for units that no server has."""

GATEWAY_TARGET_FAILED = 0x0B

_time_ns = attrgetter("time_ns")


class ModbusModel(BusModel[OnModbus]):
    def __init__(
        self,
        line: Mode | None = None,
        direct_unit: int | None = None,
        answers_for_unknown_units: bool = False,
    ) -> None:
        """`line` is how frames are written on a serial line; None for TCP."""
        is_line = line is not None
        self._line = line
        self._routing = Routing(is_line, direct_unit)
        self._answers_for_unknown = answers_for_unknown_units and not is_line
        self._due: list[Delivery[OnModbus]] = []  # in order of time
        self._collected_ns = 0
        self._requests = self._responses = self._unasked = 0

    @property
    def units(self) -> Collection[int]:
        """The units that members have served so far; none if one serves all."""
        return self._routing.units

    def join(self, member: str) -> None:
        self._routing.join(member)

    def leave(self, member: str) -> None:
        self._routing.leave(member)
        self._due = [delivery for delivery in self._due if delivery.sender != member]

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self._routing.listen(member, interest)

    def submit(self, now_ns: int, member: str, message: OnModbus) -> None:
        if now_ns < self._collected_ns:
            now_ns = self._collected_ns
        if isinstance(message, ModbusRequest):
            self._requests += 1
            state = message.line
            if state is None and self._line is not None:  # of a member that has no port
                state = LineState(self._requests, 0, self._line == "ascii")
            request, servers = self._routing.ask(member, message, state)
            self._add(Delivery(now_ns, member, request, servers))
            if not servers and self._answers_for_unknown:
                pdu = bytes((message.pdu[0] | 0x80, GATEWAY_TARGET_FAILED))
                asked = Asked(request.unit, request.exchange)
                answer = ModbusResponse(message.unit, pdu, message.exchange, asked)
                self._add(Delivery(now_ns, GATEWAY, answer, (member,)))
        elif isinstance(message, ClientConnected):
            self._add(Delivery(now_ns, member, message, self._routing.listeners))
        elif isinstance(message, ModbusResponse) and (routed := self._routing.answer(message)) is not None:
            self._responses += 1
            self._add(Delivery(now_ns, member, *routed))
        else:
            self._unasked += 1

    def next_ns(self) -> int | None:
        return self._due[0].time_ns if self._due else None

    def collect(self, now_ns: int) -> list[Delivery[OnModbus]]:
        due = self._due
        if not due or due[0].time_ns > now_ns:
            return []
        if due[-1].time_ns <= now_ns:
            self._due = []
        else:
            count = sum(delivery.time_ns <= now_ns for delivery in due)
            due, self._due = due[:count], due[count:]
        self._collected_ns = due[-1].time_ns
        return due

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            "requests": float(self._requests),
            "responses": float(self._responses),
            "responses without a request": float(self._unasked),
        }

    def _add(self, delivery: Delivery[OnModbus]) -> None:
        due = self._due
        if not due or due[-1].time_ns <= delivery.time_ns:
            due.append(delivery)
        else:
            insort(due, delivery, key=_time_ns)
