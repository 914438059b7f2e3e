"""The socketcand protocol: outside clients join a CAN bus over TCP, in ASCII.

Source: github.com/linux-can/socketcand, doc/protocol.md, and its daemon where the document is silent: an unknown
command is answered by `< error unknown command >`, one with wrong parameters is dropped silently, and a wrong bus name
ends the connection.  Time stamps are the time of day, by the hub's clock.  Each connection is a member of the bus.

Bytes that are no command end the connection, as with the daemon, so that nothing behind the header of an HTTP request
is obeyed.  Deviations: a command may be spread over several TCP segments, and the amount of white space does not matter
(the daemon ends the connection).  `< statistics >` counts what this connection has received
and sent.
Left out: the UDP beacon (it is a broadcast, and traffic stays on this machine), bit timing and control mode bits (they
are part of the rig's configuration), ISO-TP mode (an unknown command, as in a daemon without it).
"""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable, Sequence
from enum import Enum, auto
from typing import Final

from fieldrig.bus import Hub
from fieldrig.clock import MS, US, Alarm, Clock
from fieldrig.link import Link
from fieldrig_bus.backlog import backlog_of
from fieldrig_bus.can import socketcand_text as text
from fieldrig_bus.can.acceptance import ERRORS, EVERYTHING, EXTENDED, REMOTE, STATE, received
from fieldrig_bus.can.broadcast_manager import CyclicJob, Subscription
from fieldrig_bus.can.frame import EXTENDED_MASK, CanFrame
from fieldrig_bus.can.notices import BusState, CanError, Notice
from fieldrig_bus.can.socketcan_errors import error_frame
from fieldrig_bus.net import Connection, ServingPort, TcpServer, join_as_client

log = logging.getLogger(__name__)

LONGEST_COMMAND: Final = 8192  # bytes; a muxfilter of 257 tuples takes 6200
SHORTEST_STATISTICS_NS: Final = 10 * MS  # the resolution of the daemon
SHORTEST_CYCLE_NS: Final = 50 * US  # about the duration of the shortest frame at 1 Mbit/s
HOLD_NS: Final = 20 * MS

_EXACTLY: Final = EXTENDED_MASK | EXTENDED | REMOTE


class Mode(Enum):
    NO_BUS = auto()
    BCM = auto()
    RAW = auto()
    CONTROL = auto()


class Session:
    """One client: it turns commands into frames of its end of the bus, and frames into text."""

    def __init__(
        self,
        clock: Clock,
        link: Link[CanFrame],
        channel: str,
        write: Callable[[bytes], None],
        close: Callable[[], None],
        epoch_ns: int = 0,
    ) -> None:
        """`epoch_ns` is the time of day at instant 0 of the clock."""
        self._clock, self._link, self._channel = clock, link, channel.encode()
        self._write, self._close, self._epoch_ns = write, close, epoch_ns
        self._mode = Mode.NO_BUS
        self._rest = b""
        self._is_closed = False
        self._held: list[bytes] | None = None
        self._jobs: dict[int, CyclicJob] = {}
        self._subscriptions: dict[int, Subscription] = {}
        self._timer = Alarm(self._clock)
        self._counts = [0, 0, 0, 0]  # bytes and frames received, bytes and frames sent
        write(b"< hi >")

    def receive(self, data: bytes) -> None:
        if self._held is not None:
            self._let_go()
        data = self._rest + data if self._rest else data
        position = 0
        while not self._is_closed:
            start = data.find(b"<", position)
            between = data[position : start if start >= 0 else len(data)]
            if between.strip():
                self._end_connection()
                return
            if start < 0:
                self._rest = b""
                return
            stop = data.find(b">", start)
            if (stop if stop >= 0 else len(data)) - start > LONGEST_COMMAND:
                self._end_connection()
            elif stop < 0:
                self._rest = data[start:]
                return
            else:
                self._on_command(data[start + 1 : stop].split())
                position = stop + 1

    @property
    def is_open(self) -> bool:
        """True when the client has opened the bus."""
        return self._mode is not Mode.NO_BUS

    def end(self) -> None:
        """End the session of a client that has disconnected."""
        self._is_closed = True
        self._leave_mode()

    def _on_command(self, words: list[bytes]) -> None:
        handler = COMMANDS[self._mode].get(words[0]) if words else None
        if handler is None and self._is_configuration(words):
            self._write(b"< error configuring interface %b >" % self._channel)
            self._end_connection()
        elif handler is None:
            self._write(b"< error unknown command >")
        else:
            try:
                handler(self, words[1:])
            except ValueError as fault:
                log.debug("socketcand: %s: %s", words, fault)

    def _is_configuration(self, words: list[bytes]) -> bool:
        return self._mode is Mode.NO_BUS and words[:1] == [self._channel] and words[1:2] in ([b"B"], [b"C"])

    def _end_connection(self) -> None:
        self._is_closed = True
        self._close()

    # modes

    def _on_open(self, words: list[bytes]) -> None:
        if words != [self._channel]:
            self._write(b"< error could not open bus >")
            self._end_connection()
        else:
            self._enter(Mode.BCM)

    def _on_rawmode(self, words: list[bytes]) -> None:
        self._enter(Mode.RAW)
        # python-can mistakes a frame that arrives together with the `< ok >` for a wrong answer.
        self._held = []
        self._timer.after(HOLD_NS, self._let_go)
        self._link.on_receive(self._on_message, [EVERYTHING, ERRORS, STATE])

    def _on_bcmmode(self, words: list[bytes]) -> None:
        self._enter(Mode.BCM)

    def _on_controlmode(self, words: list[bytes]) -> None:
        self._enter(Mode.CONTROL)
        self._link.on_receive(self._count)

    def _enter(self, mode: Mode) -> None:
        self._leave_mode()
        self._mode = mode
        self._link.on_receive(self._on_subscribed, [])
        self._write(b"< ok >")

    def _leave_mode(self) -> None:
        """Leave a mode.  Its jobs and subscriptions end with it, as with a broadcast manager's socket."""
        for job in self._jobs.values():
            job.stop()
        for subscription in self._subscriptions.values():
            subscription.stop()
        self._jobs.clear()
        self._subscriptions.clear()
        self._held = None
        self._timer.stop()

    def _let_go(self) -> None:
        held, self._held = self._held, None
        for each in held or ():
            self._write(each)

    def _on_echo(self, words: list[bytes]) -> None:
        self._write(b"< echo >")

    # sending

    def _on_send(self, words: list[bytes]) -> None:
        self._send(text.data_frame(words))

    def _on_sendrtr(self, words: list[bytes]) -> None:
        self._send(text.remote_frame(words))

    def _on_fdsend(self, words: list[bytes]) -> None:
        self._send(text.fd_frame(words))

    def _send(self, frame: CanFrame) -> None:
        counts = self._counts
        counts[2] += len(frame.data)
        counts[3] += 1
        self._link.send(frame)

    # the broadcast manager

    def _on_add(self, words: list[bytes]) -> None:
        seconds, microseconds, *rest = words
        interval_ns, frame = text.interval_ns(seconds, microseconds), text.data_frame(rest)
        if interval_ns:
            interval_ns = max(interval_ns, SHORTEST_CYCLE_NS)
        self._delete(received(frame))
        self._jobs[received(frame)] = CyclicJob(self._clock, self._send, frame, interval_ns)

    def _on_update(self, words: list[bytes]) -> None:
        frame = text.data_frame(words)
        job = self._jobs.get(received(frame))
        if job is not None:
            job.frame = frame

    def _on_delete(self, words: list[bytes]) -> None:
        (identifier,) = words
        self._delete(text.key(identifier))

    def _delete(self, key: int) -> None:
        job = self._jobs.pop(key, None)
        if job is not None:
            job.stop()

    def _on_subscribe(self, words: list[bytes]) -> None:
        seconds, microseconds, identifier = words
        self._subscribe(identifier, text.interval_ns(seconds, microseconds), ())

    def _on_filter(self, words: list[bytes]) -> None:
        seconds, microseconds, identifier, *rest = words
        mask = text.data_frame([identifier, *rest]).data
        self._subscribe(identifier, text.interval_ns(seconds, microseconds), [mask])

    def _on_muxfilter(self, words: list[bytes]) -> None:
        seconds, microseconds, identifier, *rest = words
        self._subscribe(identifier, text.interval_ns(seconds, microseconds), text.masks(rest))

    def _subscribe(self, identifier: bytes, interval_ns: int, masks: Sequence[bytes]) -> None:
        key = text.key(identifier)
        self._unsubscribe(key)
        self._subscriptions[key] = Subscription(self._clock, self._tell_subscribed, interval_ns, masks)
        self._listen()

    def _on_unsubscribe(self, words: list[bytes]) -> None:
        (identifier,) = words
        self._unsubscribe(text.key(identifier))
        self._listen()

    def _unsubscribe(self, key: int) -> None:
        subscription = self._subscriptions.pop(key, None)
        if subscription is not None:
            subscription.stop()

    def _listen(self) -> None:
        self._link.on_receive(self._on_subscribed, [(key, _EXACTLY) for key in self._subscriptions])

    def _on_subscribed(self, frame: CanFrame) -> None:
        self._count(frame)
        subscription = self._subscriptions.get(received(frame))
        if subscription is not None and not frame.is_fd:
            subscription.hear(frame)

    def _tell_subscribed(self, frame: CanFrame) -> None:
        self._write(text.frame_text(frame, self._time_ns(), " "))

    # raw mode

    def _on_message(self, message: CanFrame | Notice) -> None:
        if isinstance(message, CanFrame):
            self._count(message)
            self._write_or_hold(text.frame_text(message, self._time_ns()))
        elif isinstance(message, CanError | BusState):
            self._write_or_hold(text.error_text(error_frame(message)[0], self._time_ns()))

    def _write_or_hold(self, line: bytes) -> None:
        if self._held is None:
            self._write(line)
        else:
            self._held.append(line)

    def _time_ns(self) -> int:
        return self._epoch_ns + self._clock.now_ns()

    # control mode

    def _count(self, frame: CanFrame) -> None:
        counts = self._counts
        counts[0] += len(frame.data)
        counts[1] += 1

    def _on_statistics(self, words: list[bytes]) -> None:
        (interval_ms,) = words
        interval_ns = min(text.number(interval_ms) * MS, text.LONGEST_INTERVAL_NS)
        self._timer.stop()
        if interval_ns:
            self._tell_later(max(interval_ns, SHORTEST_STATISTICS_NS))

    def _tell_later(self, interval_ns: int) -> None:
        def tell() -> None:
            self._tell_later(interval_ns)
            self._write(b"< stat %d %d %d %d >" % tuple(self._counts))

        self._timer.after(interval_ns, tell)


COMMANDS: Final[dict[Mode, dict[bytes, Callable[[Session, list[bytes]], None]]]] = {
    Mode.NO_BUS: {b"open": Session._on_open},
    Mode.BCM: {
        b"send": Session._on_send,
        b"sendrtr": Session._on_sendrtr,
        b"add": Session._on_add,
        b"update": Session._on_update,
        b"delete": Session._on_delete,
        b"subscribe": Session._on_subscribe,
        b"filter": Session._on_filter,
        b"muxfilter": Session._on_muxfilter,
        b"unsubscribe": Session._on_unsubscribe,
        b"rawmode": Session._on_rawmode,
        b"controlmode": Session._on_controlmode,
        b"echo": Session._on_echo,
    },
    Mode.RAW: {
        b"send": Session._on_send,
        b"sendrtr": Session._on_sendrtr,
        b"fdsend": Session._on_fdsend,
        b"bcmmode": Session._on_bcmmode,
        b"controlmode": Session._on_controlmode,
        b"echo": Session._on_echo,
    },
    Mode.CONTROL: {
        b"statistics": Session._on_statistics,
        b"bcmmode": Session._on_bcmmode,
        b"rawmode": Session._on_rawmode,
        b"echo": Session._on_echo,
    },
}


class _Client(Connection):
    def __init__(self, server: TcpServer, hub: Hub, channel: str) -> None:
        super().__init__(server)
        self._hub, self._channel = hub, channel

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        super().connection_made(transport)
        clock = self._hub.clock
        self._member, link = join_as_client(self._hub, "socketcand")
        epoch_ns = time.time_ns() - clock.now_ns()
        self._session = Session(clock, link, self._channel, self.write, self.transport.close, epoch_ns)
        self._backlog = backlog_of(self, self._hub, self._member)

    def end_of_first(self, data: bytes) -> int:
        return data.find(b">") + 1 or len(data)

    def data_received(self, data: bytes) -> None:
        self._session.receive(data)
        if self._session.is_open:
            self.heard()
        self._backlog.look()

    def connection_lost(self, exc: Exception | None) -> None:
        self._backlog.close()
        self._session.end()
        self._hub.leave(self._member)
        super().connection_lost(exc)


class SocketcandPort(ServingPort):
    """Listens at the address `listen`; clients open the bus under the name `channel`."""

    def __init__(self, listen: str, channel: str) -> None:
        self._listen, self._channel = listen, channel
        self._server: TcpServer | None = None

    @property
    def port(self) -> int:
        """The TCP port on which it listens, once it is open."""
        assert self._server is not None
        return self._server.port

    async def open(self, hub: Hub) -> None:
        self._server = TcpServer(self._listen, lambda server: _Client(server, hub, self._channel), service="socketcand")
        await self._server.open(hub.pace)

    def servers(self) -> Iterable[TcpServer]:
        return () if self._server is None else (self._server,)

    async def close(self) -> None:
        if self._server is not None:
            await self._server.close()
