"""The servers in a capture of a network: each has units of its own, so each is a bus of its own.

A capture has the sender of a message and not where it goes.  A client has a connection, which is its address with its
port, to one server, which the first answer shows.
"""

import re
from collections import OrderedDict, deque
from collections.abc import Callable, Iterable, Iterator
from typing import Final

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import is_response
from fieldrig_devices.dialogues.modbus_dialogues import ModbusDialogues, is_address
from fieldrig_devices.dialogues.modbus_exchange import ModbusExchange

PORT: Final = ":502"
MOST_KEPT: Final = 512
"""Messages that wait until the server of a client is known."""
MOST_CLIENTS: Final = 4_096


def bus_of_server(bus: str, server: str) -> str:
    """Return the name of the bus that a server is, such as `modbus-10.0.0.5`."""
    return f"{bus}-{server.removesuffix(PORT)}"


def plain_bus(name: str) -> str:
    """Return the name of a bus as a rig file may have it, such as `modbus-10-0-0-5`."""
    plain = re.sub(r"[^a-z0-9_-]+", "-", name.lower()).strip("-_")
    return plain if re.match(r"[a-z]", plain) else f"bus-{plain}".rstrip("-")


class ModbusServers:
    """Gives the messages from and to each server the bus that it is."""

    def __init__(self, bus_of: Callable[[str, str], str | None]) -> None:
        """`bus_of` returns the bus for a server of a bus of the log; None leaves its messages where they are."""
        self._bus_of = bus_of
        self._dialogues = ModbusDialogues()
        self._server_of: OrderedDict[str, str] = OrderedDict()
        """The server of each client; empty for one that no server has answered."""
        self._kept: deque[TraceEntry] = deque()

    def of(self, entries: Iterable[TraceEntry]) -> Iterator[TraceEntry]:
        """Yield the messages in their order, with the buses of their servers."""
        for number, entry in enumerate(entries):
            self._learn(number, entry)
            self._kept.append(entry)
            if len(self._kept) > MOST_KEPT:
                self._know(self._kept[0].sender, "")
            while self._kept and self._is_known(self._kept[0]):
                yield self._renamed(self._kept.popleft())
        yield from map(self._renamed, self._kept)
        self._kept.clear()

    def _learn(self, number: int, entry: TraceEntry) -> None:
        for ended in self._dialogues.take(number, entry):
            if isinstance(ended, ModbusExchange) and is_address(ended.server):
                self._know(ended.client, ended.server)

    def _know(self, client: str, server: str) -> None:
        self._server_of[client] = server
        if len(self._server_of) > MOST_CLIENTS:
            self._server_of.popitem(last=False)

    def _is_known(self, entry: TraceEntry) -> bool:
        return not _is_request(entry) or entry.sender in self._server_of

    def _renamed(self, entry: TraceEntry) -> TraceEntry:
        if entry.family != "modbus" or not is_address(entry.sender):
            return entry
        server = self._server_of.get(entry.sender, "") if _is_request(entry) else entry.sender
        bus = self._bus_of(entry.bus, server) if server else None
        return entry if bus is None else entry._replace(bus=bus)


def _is_request(entry: TraceEntry) -> bool:
    return entry.family == "modbus" and not is_response(entry.data) and is_address(entry.sender)
