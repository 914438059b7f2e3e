"""The ways from outside into the controller besides its field buses: TCP services over Ethernet, and calls at COM1.

Source: PacDrive manual 4447-4490, 5188-5217 (digest PD-240, PD-241, PD-280 to PD-283).
"""

from typing import Protocol

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig_bus.ip.message import RelayMessage
from fieldrig_bus.serial.message import SerialMessage
from fieldrig_bus.tcp.message import TcpMessage
from fieldrig_devices.connections.face import TcpFace
from fieldrig_devices.ftp.login import FtpLogin
from fieldrig_devices.ip.services import RelayedServices
from fieldrig_devices.max4.com1.dial_in import Chance, DialIn, Owner
from fieldrig_devices.max4.com1.parameters import Com1Parameters
from fieldrig_devices.max4.com1.port import Com1
from fieldrig_devices.max4.core import Controller
from fieldrig_devices.max4.pages.site import default_pages
from fieldrig_devices.max4.services import at_own_ports, services_of
from fieldrig_devices.max4.settings import Max4Settings
from fieldrig_devices.max4.storage.disk import FlashDisk


class Host(Controller, Owner, Protocol):
    """The controller, as this part sees it."""

    @property
    def com1_parameters(self) -> Com1Parameters:
        """The parameters of the present boot."""


class Network:
    """The network of one controller, over links of which each may be missing."""

    def __init__(
        self,
        clock: Clock,
        random: Chance,
        name: str,
        host: Host,
        disk: FlashDisk,
        settings: Max4Settings,
        com1: Link[SerialMessage] | None,
        tcp: Link[TcpMessage] | None,
        relay: Link[RelayMessage] | None,
    ) -> None:
        ftp = settings.ftp
        login = None if ftp is None else FtpLogin(ftp.user_name, ftp.password, host.login_refused)
        services = services_of(clock, host, disk, settings.load.tcp_us, login, settings.http_names)
        relayed = None if relay is None else RelayedServices(name, relay, lambda: self._dial_in.wake())
        self._host = host
        self._tcp = None if tcp is None else TcpFace(tcp, services, host.tcp_connected)
        self._dial_in = DialIn(clock, random, host, at_own_ports(services), lambda: host.com1_parameters, relayed)
        self.com1 = Com1(clock, com1, self._dial_in.answer, settings.com1.baud)
        has_pages = tcp is not None or settings.com1.modem is not None
        self.pages = default_pages() if has_pages else {}
        """The files that it serves to a browser; none if no browser can reach it."""

    def boot(self) -> None:
        """Begin with the parameters of a boot."""
        self.com1.boot(self._host.com1_parameters)
        if self._tcp is not None:
            self._tcp.open()

    def limits_reached(self) -> dict[str, float]:
        """Return how often callers reached each limit; the clients at `tcp` are counted there."""
        return self._dial_in.reached.figures()

    def end(self) -> None:
        """End all connections and calls, at power-off or before another boot."""
        self.com1.end()
        if self._tcp is not None:
            self._tcp.close()
