"""A network of python canopen on a bus that is not its own, for as long as a test needs it."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import canopen

BusOf = dict[str, Any]
"""Arguments of python-can's `Bus`."""


@contextmanager
def network_on(bus: BusOf) -> Iterator[canopen.Network]:
    network = canopen.Network()
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
