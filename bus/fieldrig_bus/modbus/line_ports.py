"""The outside end of a serial line on a pty, or at the other end of a TCP connection that carries its bytes.

There is a master, or, with `servers`, those units; then the line's master is in the rig.
"""

from collections.abc import Callable
from typing import Any, Final

from fieldrig.bus import Hub, Port
from fieldrig.link import Link
from fieldrig.outside.limits import Reached
from fieldrig_bus.backlog import Backlog, backlog_of
from fieldrig_bus.modbus.dialler import Dialler, Handlers
from fieldrig_bus.modbus.line_place import MakeSession, ModbusLineSettings, Session
from fieldrig_bus.modbus.sockets import Master, Masters, MastersPort
from fieldrig_bus.serial.urlhandler import register
from fieldrig_bus.terminal import Terminal, terminal

register()

MOST_WAITING: Final = 16
"""Requests of a master that may wait for the line; what is no request counts by its characters."""
MOST_OF_A_LINE: Final = 256
"""Bytes that are read from one at a time: the longest frame of RTU."""


class _Intake:
    """The bytes from outside for a session; the other end waits while there are more than the line carries."""

    def __init__(self, session: Session, backlog: Backlog) -> None:
        self._session, self._backlog = session, backlog

    def take(self, data: bytes) -> None:
        self._session.on_bytes(data)
        self._backlog.look()

    def close(self) -> None:
        self._backlog.close()
        self._session.close()


def _intake(
    hub: Hub, member: str, session: Session, read_on: Callable[[bool], None], reached: Reached, why: str
) -> _Intake:
    """Return the intake of a port; `why` is noted as a reached limit whenever the other end has to wait."""

    def note() -> None:
        reached.note("clients that had to wait", why)

    return _Intake(session, Backlog(hub, member, read_on, note, MOST_WAITING, lambda: session.ahead))


class PtyPort(Port):
    def __init__(self, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._name, self._member, self._make_session = settings.pty or "", settings.member("pty"), make_session
        self._is_master = bool(settings.servers)
        self._hub: Hub | None = None
        self._pty: Terminal | None = None
        self._intake: _Intake | None = None
        self._reached = Reached(f"pty {self._name}")

    async def open(self, hub: Hub) -> None:
        pty = terminal(hub, self._name)
        session = self._make_session(hub, hub.join(self._member), self._ask if self._is_master else pty.write)
        why = "a program writes more than the line carries"
        intake = _intake(hub, self._member, session, pty.read_on, self._reached, why)
        self._hub, self._pty, self._intake = hub, pty, intake
        pty.open(intake.take)

    def statistics(self) -> dict[str, float]:
        return self._reached.figures()

    async def close(self) -> None:
        if self._hub is None or self._pty is None or self._intake is None:
            return
        self._pty.close()
        self._intake.close()
        self._hub.leave(self._member)
        self._hub = None

    def _ask(self, data: bytes) -> None:
        """Discard requests that no server has read, so that a server that opens the pty later does not get them."""
        if self._pty is not None:
            self._pty.forget()
            self._pty.write(data)


class TcpLinePort(MastersPort):
    """RTU or ASCII over TCP, like a serial device server."""

    def __init__(self, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        def make(masters: Masters, hub: Hub) -> Master:
            return _LineMaster(masters, hub, make_session)

        super().__init__(settings.listen or "", make, settings.max_connections)


class _LineMaster(Master):
    def __init__(self, server: Masters, hub: Hub, make_session: MakeSession) -> None:
        super().__init__(server, hub, MOST_OF_A_LINE)
        self._make_session = make_session

    def on_open(self, link: Link[Any]) -> None:
        session = self._make_session(self.hub, link, self.transport.write)
        backlog = backlog_of(self, self.hub, self.member, MOST_WAITING, lambda: session.ahead)
        self._intake = _Intake(session, backlog)

    def on_bytes(self, data: bytes) -> None:
        self.heard()  # every character is valid on a line
        self._intake.take(data)

    def on_close(self) -> None:
        self._intake.close()


class DiallingPort(Port):
    """RTU or ASCII over TCP, to a serial device server."""

    def __init__(self, bus: str, settings: ModbusLineSettings, make_session: MakeSession) -> None:
        self._address, self._member, self._make_session = settings.dial or "", settings.member("dial"), make_session
        self._dialler = Dialler(bus, self._address, Handlers(_pass, self._on_bytes, _pass, lambda: True))
        self._hub: Hub | None = None
        self._intake: _Intake | None = None
        self._reached = Reached(f"{bus}: {self._address}")

    async def open(self, hub: Hub) -> None:
        """Start connecting; the serial server may start later."""
        session = self._make_session(hub, hub.join(self._member), self._dialler.write)
        why = "a serial server sends more than the line carries"
        self._hub = hub
        self._intake = _intake(hub, self._member, session, self._dialler.read_on, self._reached, why)
        self._dialler.want()

    def statistics(self) -> dict[str, float]:
        return self._reached.figures()

    async def close(self) -> None:
        await self._dialler.close()
        if self._hub is not None and self._intake is not None:
            self._intake.close()
            self._hub.leave(self._member)
        self._hub = None

    def _on_bytes(self, data: bytes) -> None:
        self._dialler.worked()
        if self._intake is not None:
            self._intake.take(data)


def _pass() -> None:
    """Do nothing: a line does not notice its connection."""
