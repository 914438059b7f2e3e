"""Routing: the servers that receive a request, and the client that receives its response.

A member that listens with unit ids is a server for them (None: for every unit); a client listens with an empty
interest.  A request goes to the servers of its unit, and its response only to the client that sent it.

A server outside is a member whose name begins with `SERVER`.  Units of the rig take precedence over it, and outside
clients cannot reach it: the bus does not connect outside programs with each other.
"""

from collections.abc import Collection, Sequence
from typing import Any

from fieldrig_bus.modbus.message import BROADCAST, CONNECTIONS, Asked, LineState, ModbusRequest, ModbusResponse

NOT_SIGNIFICANT = frozenset({0, 255})
"""Unit ids for a server that its IP address alone identifies (Modbus messaging on TCP/IP guide V1.0b, chapter 4)."""

SERVER = "server:"
OUTSIDE = ":"
"""Separator in the name of a member that is not a device."""

MOST_OPEN = 4096
"""Exchanges that may wait for an answer.  Beyond that the oldest is dropped: a silent server must not fill memory."""


class Routing:
    """Unit 0 is a broadcast if `is_line`.  Otherwise 0 and 255 mean `direct_unit`, or without it the only unit."""

    def __init__(self, is_line: bool, direct_unit: int | None = None) -> None:
        self._is_line, self._direct_unit = is_line, direct_unit
        self._interests: dict[str, frozenset[int] | None] = {}  # None: every unit
        self._routes: dict[int, tuple[int, tuple[str, ...]]] = {}  # by requested unit; filled on demand
        self._open: dict[
            int, tuple[str, int, int, Asked]
        ] = {}  # client, exchange and unit of its response, its request
        self._numbered = 0
        self._has_servers_outside = False
        self._seen: set[int] = set()
        self._is_for_all = False
        """True once a member has been a server for every unit."""
        self.listeners: tuple[str, ...] = ()
        """Members that want to be notified of connections."""

    @property
    def units(self) -> Collection[int]:
        """The units that members have served so far, also those without power now; none if one serves all."""
        return () if self._is_for_all else self._seen

    def join(self, member: str) -> None:
        self._interests[member] = frozenset()

    def leave(self, member: str) -> None:
        self._interests.pop(member, None)
        self._routes.clear()
        self.listeners = tuple(name for name in self.listeners if name != member)
        for exchange in [exchange for exchange, (client, *_) in self._open.items() if client == member]:
            del self._open[exchange]

    def listen(self, member: str, interest: Sequence[Any] | None) -> None:
        wanted = () if interest is None else interest
        units = frozenset(int(unit) for unit in wanted if unit != CONNECTIONS)
        self._interests[member] = None if interest is None else units
        self._seen |= units
        self._is_for_all |= interest is None
        self._routes.clear()
        self._has_servers_outside = any(map(is_server_outside, self._interests))
        self.listeners = tuple(name for name in self.listeners if name != member)
        if CONNECTIONS in wanted:
            self.listeners += (member,)

    def ask(self, client: str, request: ModbusRequest, line: LineState | None) -> tuple[ModbusRequest, tuple[str, ...]]:
        """The request as its servers see it, and their names.  Its exchange is open after this."""
        unit = request.unit
        target, servers = self._routes.get(unit) or self._find(unit)
        if client in servers:
            servers = tuple(name for name in servers if name != client)
        if self._has_servers_outside and not (self._is_line and unit == BROADCAST):
            servers = _nearest(client, servers)
        self._numbered = exchange = self._numbered + 1 & 0xFFFF_FFFF
        if servers and not (self._is_line and unit == BROADCAST):
            self._open[exchange] = (client, request.exchange, unit, Asked(target, exchange))
            if len(self._open) > MOST_OPEN:
                del self._open[next(iter(self._open))]
        return ModbusRequest(target, request.pdu, exchange, line), servers

    def answer(self, response: ModbusResponse) -> tuple[ModbusResponse, tuple[str]] | None:
        """The response as its client sees it, and the client; None if no client waits for it."""
        asked = self._open.pop(response.exchange, None)
        if asked is None:
            return None
        client, exchange, unit, request = asked
        return ModbusResponse(unit, response.pdu, exchange, request), (client,)

    def _find(self, unit: int) -> tuple[int, tuple[str, ...]]:
        if self._is_line and unit == BROADCAST:
            servers = tuple(name for name, units in self._interests.items() if units is None or units)
            route = (unit, servers)
        else:
            target = self._target(unit)
            route = (target, tuple(name for name, units in self._interests.items() if units is None or target in units))
        self._routes[unit] = route
        return route

    def _target(self, unit: int) -> int:
        if self._is_line or unit not in NOT_SIGNIFICANT:
            return unit
        if self._direct_unit is not None:
            return self._direct_unit
        inside = (units for name, units in self._interests.items() if units and not is_server_outside(name))
        units: set[int] = set().union(*inside)
        return units.pop() if len(units) == 1 else unit


def is_server_outside(member: str) -> bool:
    return member.startswith(SERVER)


def _nearest(client: str, servers: tuple[str, ...]) -> tuple[str, ...]:
    inside = tuple(name for name in servers if not is_server_outside(name))
    return inside if inside or OUTSIDE in client else servers
