"""The services of the controller over TCP: HTTP with the diagnosis pages.

Source: PacDrive manual 3219, 4319, 5188-5217 (digest PD-076, PD-281 to PD-283).  Each request takes processor time
at the priority of TCP/IP, and each new connection is entry 8013.
"""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig_devices.connections.connection import Connection, Serve, Session
from fieldrig_devices.http.server import serving
from fieldrig_devices.iec.tasks.system_work import TCP_PRIORITY
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.pages.site import Site
from fieldrig_devices.max4.storage.disk import FlashDisk

PORTS: Final = {"http": 80, "ftp": 21}
"""TCP ports of the services at the controller's own address (manual 5597-5611)."""


def services_of(clock: Clock, controller: Controller, disk: FlashDisk, tcp_us: int) -> Mapping[str, Serve]:
    """Return the services by name; `tcp_us` is the processor time of a request."""
    site = Site(controller, disk)
    at_priority = partial(controller.at_priority, TCP_PRIORITY, tcp_us)
    return {"http": partial(_Prioritised, serving(clock, site.answer), at_priority)}


def at_own_ports(services: Mapping[str, Serve]) -> dict[int, Serve]:
    """Return the services by their TCP ports at the controller's own address."""
    return {PORTS[name]: serve for name, serve in services.items()}


class _Prioritised:
    """A session that handles what arrives when it is the turn of TCP/IP."""

    def __init__(self, serve: Serve, at_priority: Callable[[Callable[[], None]], None], connection: Connection) -> None:
        self._session: Session = serve(connection)
        self._at_priority = at_priority

    def received(self, data: bytes) -> None:
        self._at_priority(partial(self._session.received, data))

    def drained(self) -> None:
        self._at_priority(self._session.drained)

    def ended(self) -> None:
        self._at_priority(self._session.ended)

    def lost(self) -> None:
        self._at_priority(self._session.lost)
