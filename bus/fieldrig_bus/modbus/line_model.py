"""A Modbus serial line as a function of time: one exchange at a time, and every frame takes the time of its characters.

Source: Modbus over serial line V1.02, 2.1 (the master issues one transaction at a time), 2.4.1 (the meaning of a
broadcast and of a missing answer) and 2.5.1.1 (3.5 characters of silence between frames).  A request during another
exchange waits for its answer or its response timeout; an answer that comes after the next request has begun is lost.  A
client that sends a new request has given up the previous one.

The answers of servers outside (see `routing`) have had their time on the line when they arrive.
"""

import logging
from collections.abc import Collection, Sequence
from typing import Any, NamedTuple

from fieldrig.bus import BusModel, Delivery
from fieldrig_bus.modbus.framing import LineTiming
from fieldrig_bus.modbus.message import BROADCAST, LineState, ModbusRequest, ModbusResponse, OnModbus
from fieldrig_bus.modbus.routing import Routing, is_server_outside

log = logging.getLogger(__name__)

MOST_WANTED = 1_000
"""Messages that may wait for the line; any more are lost, as no client waits so long for an answer."""


class _Wanted(NamedTuple):
    """A message that waits.  Where two have the same start, the order of asking decides."""

    asked_ns: int
    order: int
    member: str
    message: ModbusRequest | ModbusResponse


class LineModel(BusModel[OnModbus]):
    def __init__(
        self, timing: LineTiming, response_timeout_ns: int, turnaround_ns: int = 0, is_paced: bool = True
    ) -> None:
        """`turnaround_ns` is the silence after a broadcast.  `is_paced` is False where a port takes the time of its
        characters itself, so that a request is heard when it begins."""
        self._timing, self._timeout_ns = timing, response_timeout_ns
        self._turnaround_ns, self._is_paced = turnaround_ns, is_paced
        self._routing = Routing(is_line=True)
        self._wanted: list[_Wanted] = []
        self._ordered = 0
        self._free_ns = 0  # the instant at which the last frame and the silence after it are over
        self._exchange: int | None = None  # the exchange that is open on the line
        self._client = ""
        self._deadline_ns = 0
        self._messages = self._lost = self._busy_ns = 0

    @property
    def units(self) -> Collection[int]:
        """The units that members have served so far; none if one serves all."""
        return self._routing.units

    def join(self, member: str) -> None:
        self._routing.join(member)

    def leave(self, member: str) -> None:
        self._routing.leave(member)
        self._wanted = [wanted for wanted in self._wanted if wanted.member != member]
        if self._client == member:
            self._exchange = None

    def listen(self, now_ns: int, member: str, interest: Sequence[Any] | None) -> None:
        self._routing.listen(member, interest)

    def submit(self, now_ns: int, member: str, message: OnModbus) -> None:
        if not isinstance(message, ModbusRequest | ModbusResponse):
            return
        if len(self._wanted) >= MOST_WANTED:
            log.debug("%s: %d messages wait for the line; dropped %r", member, MOST_WANTED, message)
            return
        if isinstance(message, ModbusRequest) and member == self._client:
            self._exchange = None
        self._ordered += 1
        self._wanted.append(_Wanted(now_ns, self._ordered, member, message))

    def waiting(self, member: str) -> int:
        return sum(wanted.member == member for wanted in self._wanted)

    def next_ns(self) -> int | None:
        following = self._next()
        return None if following is None else self._arrival_ns(*following)

    def collect(self, now_ns: int) -> list[Delivery[OnModbus]]:
        arrived = []
        while (following := self._next()) is not None and self._arrival_ns(*following) <= now_ns:
            delivery = self._carry(*following)
            if delivery is not None:
                arrived.append(delivery)
        return arrived

    def statistics(self, now_ns: int) -> dict[str, float]:
        return {
            "messages": float(self._messages),
            "answers too late": float(self._lost),
            "busy s": self._busy_ns / 1e9,
        }

    def _next(self) -> tuple[int, _Wanted] | None:
        """The next message on the line, and the instant at which it begins."""
        starts = [(self._start_ns(wanted), wanted.order, wanted) for wanted in self._wanted]
        if not starts:
            return None
        start_ns, _, wanted = min(starts)
        return start_ns, wanted

    def _start_ns(self, wanted: _Wanted) -> int:
        start_ns = max(wanted.asked_ns, self._free_ns)
        if self._exchange is not None and isinstance(wanted.message, ModbusRequest):
            return max(start_ns, self._deadline_ns)
        return start_ns

    def _arrival_ns(self, start_ns: int, wanted: _Wanted) -> int:
        is_early = not self._is_paced and isinstance(wanted.message, ModbusRequest)
        return start_ns if is_early else self._over_ns(start_ns, wanted)

    def _over_ns(self, start_ns: int, wanted: _Wanted) -> int:
        if is_server_outside(wanted.member):
            return start_ns
        return start_ns + self._timing.frame_ns(len(wanted.message.pdu)) + self._timing.silence_ns

    def _carry(self, start_ns: int, wanted: _Wanted) -> Delivery[OnModbus] | None:
        self._wanted.remove(wanted)
        message, arrival_ns = wanted.message, self._arrival_ns(start_ns, wanted)
        over_ns = self._over_ns(start_ns, wanted)
        if isinstance(message, ModbusRequest):
            self._messages += 1
            line = LineState(self._messages, 0, self._timing.mode == "ascii")
            request, servers = self._routing.ask(wanted.member, message, line)
            self._client, self._deadline_ns = wanted.member, over_ns + self._timeout_ns
            self._occupy(start_ns, over_ns)
            if message.unit == BROADCAST:
                self._exchange = None
                self._free_ns += self._turnaround_ns
            else:
                self._exchange = request.exchange
            return Delivery(arrival_ns, wanted.member, request, servers)
        answer = self._routing.answer(message) if message.exchange == self._exchange else None
        if answer is None:
            self._lost += 1
            return None
        self._messages += 1
        self._exchange = None
        self._occupy(start_ns, over_ns)
        return Delivery(arrival_ns, wanted.member, *answer)

    def _occupy(self, start_ns: int, over_ns: int) -> None:
        self._free_ns = over_ns
        self._busy_ns += over_ns - start_ns
