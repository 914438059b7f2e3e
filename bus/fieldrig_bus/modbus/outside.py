"""Servers outside the rig that devices on `modbus.tcp` use: their settings, and the connection to one address.

All units of one address share a connection, as units behind a gateway do.  While it is being established, requests
wait up to the response timeout.  A request without a response is not answered here either: the client that sent it has
a timeout of its own.
"""

import ipaddress
import logging
import re
from collections import deque
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, Final

from pydantic import AfterValidator, Field

from fieldrig.bus import Hub, Port
from fieldrig.clock import MS, Alarm
from fieldrig.link import Link
from fieldrig.outside.addresses import split_address
from fieldrig.settings import Settings
from fieldrig_bus.modbus.dialler import Dialler, Handlers
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_bus.modbus.routing import SERVER
from fieldrig_bus.modbus.transactions import Transactions

log = logging.getLogger(__name__)

HIGHEST_UNIT: Final = 247
UnitId = Annotated[int, Field(ge=1, le=HIGHEST_UNIT, description="unit id")]

MOST_WAITING: Final = 64
MOST_SILENCE: Final = 3
"""Consecutive requests without a response, after which a connection is considered dead."""

_LABEL: Final = r"[a-z0-9_](?:[a-z0-9_-]{0,61}[a-z0-9_])?"
_HOST: Final = re.compile(
    rf"(?:{_LABEL}\.)*(?!\d+\Z){_LABEL}", re.IGNORECASE
)  # RFC 1123, 2.1; a plain number is not allowed
_LONGEST_HOST: Final = 253


def _is_host(host: str) -> bool:
    try:
        address = ipaddress.ip_address(host.partition("%")[0])
    except ValueError:
        return len(host) <= _LONGEST_HOST and _HOST.fullmatch(host) is not None
    return not (address.is_multicast or address.is_unspecified or host == "255.255.255.255")


def _of_a_server(text: str) -> str:
    host, port = split_address(text)
    address = f"[{host}]:{port}" if ":" in host else f"{host}:{port}"
    if text.removeprefix("tcp://").lower() != address or port == 0 or not _is_host(host):
        raise ValueError(f"{text!r} is not the address of a server: expected HOST:PORT, such as 192.168.1.5:502")
    return address


ServerAddress = Annotated[
    str, AfterValidator(_of_a_server), Field(description="host:port of a server, such as 192.168.1.5:502")
]


class OutsideServer(Settings):
    address: ServerAddress
    unit: int | None = Field(
        default=None, ge=0, le=255, description="unit id of the device at the server; null: the same"
    )


def _of_units(servers: dict[int, Any]) -> dict[int, Any]:
    if wrong := [unit for unit in servers if not 1 <= unit <= HIGHEST_UNIT]:
        raise ValueError(f"{', '.join(map(str, wrong))}: expected unit ids from 1 to {HIGHEST_UNIT}")
    return servers


Servers = Annotated[dict[int, ServerAddress | OutsideServer], AfterValidator(_of_units)]


def by_address(servers: Servers) -> dict[str, dict[int, int]]:
    """Unit ids in the rig, with the unit ids at their server, by address."""
    units: dict[str, dict[int, int]] = {}
    for unit, server in servers.items():
        outside = OutsideServer(address=server) if isinstance(server, str) else server
        units.setdefault(outside.address, {})[unit] = unit if outside.unit is None else outside.unit
    return units


class ServersPort(Port):
    """The connection to one address, with its units."""

    def __init__(self, bus: str, address: str, units: Mapping[int, int], response_timeout_ms: int) -> None:
        self._bus, self._address, self._units = bus, address, units
        self._timeout_ns = response_timeout_ms * MS
        self._hub: Hub | None = None
        self._session: _Session | None = None

    async def open(self, hub: Hub) -> None:
        """Start; the connection is opened for the first request."""
        link = hub.join(f"{SERVER}{self._address}")
        self._hub = hub
        self._session = _Session(hub, link, self._bus, self._address, self._units, self._timeout_ns)

    async def close(self) -> None:
        if self._session is not None:
            await self._session.close()
            self._session = None
        if self._hub is not None:
            self._hub.leave(f"{SERVER}{self._address}")
            self._hub = None


class _Session:
    def __init__(
        self, hub: Hub, link: Link[Any], bus: str, address: str, units: Mapping[int, int], timeout_ns: int
    ) -> None:
        self._clock, self._link, self._units, self._timeout_ns = hub.clock, link, units, timeout_ns
        self._transactions = Transactions(timeout_ns)
        self._waiting: deque[tuple[int, ModbusRequest]] = deque()  # by deadline
        self._silence = 0
        self._wake = Alarm(self._clock)
        self._dialler = Dialler(
            bus, address, Handlers(self._go_on, self._on_bytes, self._on_close, lambda: bool(self._in_time()))
        )
        link.on_receive(self._on_request, list(units))

    async def close(self) -> None:
        self._waiting.clear()
        self._wake.stop()
        await self._dialler.close()

    def _on_request(self, request: ModbusRequest) -> None:
        self._in_time()
        if len(self._waiting) < MOST_WAITING:
            self._waiting.append((self._clock.now_ns() + self._timeout_ns, request))
        self._go_on()

    def _go_on(self) -> None:
        waiting, transactions = self._in_time(), self._transactions
        if waiting and not self._dialler.is_open:
            self._dialler.want()
            return
        while waiting and not transactions.is_full:
            _, request = waiting.popleft()
            self._dialler.write(transactions.ask(self._clock.now_ns(), request, self._units[request.unit]))
        self._wake_up()

    def _in_time(self) -> deque[tuple[int, ModbusRequest]]:
        """Requests that wait and have not reached their deadline."""
        now_ns = self._clock.now_ns()
        while self._waiting and self._waiting[0][0] <= now_ns:
            self._waiting.popleft()
        return self._waiting

    def _on_bytes(self, data: bytes) -> None:
        self._silence = 0
        for response in self._transactions.feed(data):
            self._dialler.worked()
            self._link.send(response)
        if self._transactions.is_lost:
            self._dialler.drop("not MBAP; closed")
        else:
            self._go_on()

    def _on_close(self) -> None:
        self._transactions = Transactions(self._timeout_ns)
        self._silence = 0
        self._wake_up()

    def _wake_up(self) -> None:
        self._wake.at(self._transactions.next_ns(), self._on_late)

    def _on_late(self) -> None:
        self._silence += self._transactions.expire(self._clock.now_ns())
        if self._silence >= MOST_SILENCE:
            self._dialler.drop("no more answers; closed")
        else:
            self._go_on()
            self._wake_up()


def listens_at(listen: str, server: str) -> bool:
    """True if the address of a server is that on which the bus itself listens, as far as can be determined."""
    (host, port), (other, other_port) = split_address(listen), split_address(server)
    return port == other_port and (host == other or _reaches(host, other))


def _reaches(listens: str, dialled: str) -> bool:
    own = {"localhost", "127.0.0.1", "::1"}
    return dialled in own and listens in own | {"0.0.0.0", "::"}


def ports_of(bus: str, servers: Servers, response_timeout_ms: int) -> Iterator[ServersPort]:
    for address, units in by_address(servers).items():
        yield ServersPort(bus, address, units, response_timeout_ms)
