"""A network of python canopen on a bus that is not its own, for as long as a test needs it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import canopen

BusOf = dict[str, Any]
"""Arguments of python-can's `Bus`."""
PATIENCE_S = 5.0
"""How long an SDO client waits: python canopen gives up after 0.3 s, which a busy host may take for an answer."""


class PatientNetwork(canopen.Network):
    """A network whose SDO clients do not give up because of the host; a test of a time-out sets its own."""

    def add_node(self, *arguments: Any, **named: Any) -> canopen.RemoteNode:
        node = super().add_node(*arguments, **named)
        node.sdo.RESPONSE_TIMEOUT = PATIENCE_S
        return node


@contextmanager
def network_on(bus: BusOf) -> Iterator[canopen.Network]:
    network = PatientNetwork()
    network.NOTIFIER_CYCLE = 0.05  # s; how long disconnecting takes
    network.connect(**bus)
    try:
        yield network
        network.check()
    finally:
        network.disconnect()


def socketcand_at(port: int) -> BusOf:
    """The bus `can0` of a rig."""
    return {"interface": "socketcand", "channel": "can0", "host": "127.0.0.1", "port": port}
