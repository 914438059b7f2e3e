"""The servers of a network in a capture: each has units of its own, and a client's port leads to one of them."""

from collections import OrderedDict
from typing import Final

from fieldrig_devices.dialogues import ModbusExchange
from fieldrig_devices.dialogues.modbus_dialogues import is_address

MOST_CLIENTS: Final = 4_096
"""Ports of clients that are remembered."""


class Servers:
    """The server of each client, as the answers have shown."""

    def __init__(self) -> None:
        self._of_clients: OrderedDict[str, str] = OrderedDict()

    def server_of(self, exchange: ModbusExchange) -> str:
        """Return the address of the server; empty where there are no addresses, or where nothing was answered yet."""
        if exchange.server:
            if not is_address(exchange.server):
                return ""
            self._of_clients[exchange.client] = exchange.server
            if len(self._of_clients) > MOST_CLIENTS:
                self._of_clients.popitem(last=False)
        return self._of_clients.get(exchange.client, "")

    def known(self, client: str) -> str | None:
        """Return the server of a client; empty where there are no addresses, None as long as nothing was answered."""
        return self._of_clients.get(client) if is_address(client) else ""

    def unit_words(self, exchange: ModbusExchange, unit: str) -> str:
        """Return `unit 1`, or `unit 1 of 10.0.0.5:502` in a capture of a network."""
        server = self.server_of(exchange)
        return f"{unit} of {server}" if server else unit
