"""The services of the controller over TCP: HTTP with the diagnosis pages, FTP to the flash disk.

Source: PacDrive manual 3219, 4319, 5188-5217 (digest PD-076, PD-281 to PD-283).  Whatever arrives takes
processor time at the priority of TCP/IP, and each new connection is entry 8013.  The manual gives no login of FTP; here
FTP exists only with one.
"""

from collections import deque
from collections.abc import Callable, Collection, Mapping
from functools import partial
from typing import Final

from fieldrig.clock import Clock
from fieldrig_devices.connections.connection import Connection, Serve, Session
from fieldrig_devices.ftp import server as ftp
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.http import server as http
from fieldrig_devices.iec.tasks.system_work import TCP_PRIORITY
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.pages.site import Site
from fieldrig_devices.max4.storage.disk import FlashDisk
from fieldrig_devices.max4.storage.ftp_files import FtpFiles

PIECE: Final = 256
"""Bytes of a client that are handled at a time: a request of most clients."""
PORTS: Final = {"http": 80, "ftp": 21}
"""TCP ports of the services at the controller's own address (manual 5597-5611)."""


def services_of(
    clock: Clock,
    controller: Controller,
    disk: FlashDisk,
    tcp_us: int,
    login: FtpLogin | None,
    names: Collection[str] = (),
) -> Mapping[str, Serve]:
    """Return the services by name.

    `tcp_us` is the processor time of a request, `login` that of FTP, and `names` are further names of the controller.
    """
    serves = {"http": http.serving(clock, Site(controller, disk).answer, names)}
    if login is not None:
        serves["ftp"] = ftp.serving(clock, FtpFiles(disk), login)
    at_priority = partial(controller.at_priority, TCP_PRIORITY, tcp_us)
    return {name: partial(_Prioritised, serve, at_priority) for name, serve in serves.items()}


def at_own_ports(services: Mapping[str, Serve]) -> dict[int, Serve]:
    """Return the services by their TCP ports at the controller's own address."""
    return {PORTS[name]: serve for name, serve in services.items()}


class _Prioritised:
    """A session that handles what arrives when it is the turn of TCP/IP.

    Each piece takes its time, so a client that sends many requests at once gets no more of the processor for them.
    One piece of a connection waits for its turn at a time, and those of a connection that is lost are dropped.
    """

    def __init__(self, serve: Serve, at_priority: Callable[[Callable[[], None]], None], connection: Connection) -> None:
        self._connection = connection
        self._session: Session = serve(connection)
        self._at_priority = at_priority
        self._waiting: deque[Callable[[], None]] = deque()
        connection.handle_later()

    def received(self, data: bytes) -> None:
        for start in range(0, len(data), PIECE):
            self._later(partial(self._handle, data[start : start + PIECE]))

    def drained(self) -> None:
        if self._session.drained not in self._waiting:
            self._later(self._session.drained)

    def ended(self) -> None:
        self._later(self._session.ended)

    def lost(self) -> None:
        self._waiting.clear()
        self._at_priority(self._session.lost)

    def _later(self, action: Callable[[], None]) -> None:
        self._waiting.append(action)
        if len(self._waiting) == 1:
            self._at_priority(self._take_turn)

    def _take_turn(self) -> None:
        if self._waiting:  # not if the connection was lost meanwhile
            self._waiting[0]()
            if self._waiting:
                self._waiting.popleft()
        if self._waiting:
            self._at_priority(self._take_turn)

    def _handle(self, data: bytes) -> None:
        self._session.received(data)
        self._connection.handled(len(data))
