"""A device's end of a bus whose hub runs in another process."""

import asyncio
import json
import logging
import time
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any

from fieldrig.bus import ModelBus
from fieldrig.clock import S
from fieldrig.errors import BusError
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig.hub.checked_link import uninteresting, unsendable
from fieldrig.hub.wire import Kind, Records, pack, socket_name
from fieldrig.loop.real_clock import RealClock
from fieldrig.outside.addresses import split_address
from fieldrig.outside.portions import Portions
from fieldrig.outside.shared_token import proof, token
from fieldrig.outside.untrusted import field, read_json, shown
from fieldrig.outside.vanished import leave_when_silent
from fieldrig.text.exception_notes import blame

log = logging.getLogger(__name__)

CONNECT_S = 2.0
"""Time for a connection over TCP.  The system itself tries for minutes, ever more seldom, so that a line that is back
would not be noticed for as long as it was cut."""
MOST_STANDING = 4_096
"""Number of standing messages that are kept for a new hub; a hub accepts no more from one member."""


class RemoteLink(asyncio.Protocol):
    """An end of the bus that keeps its handler and interest when its hub is lost.  Call `connect` when the hub is back.

    While there is no hub, messages are dropped.  The last standing messages (`ModelBus.standing_of`) are sent to the
    new hub.
    """

    def __init__(
        self, bus: ModelBus[Any], member: str, clock: RealClock, run: Path, on_lost: Callable[[str], None]
    ) -> None:
        self._bus, self._member, self._clock, self._run, self._on_lost = bus, member, clock, run, on_lost
        self._check, self._encode, self._decode = bus.check, bus.encode, bus.decode
        self._standing_of, self._standing = bus.standing_of, dict[Hashable, bytes]()
        self._handler: Callable[[Any], None] | None = None
        self._interest: Sequence[object] | None = None
        self._transport: asyncio.Transport | None = None
        """The connection to a hub that has accepted this member."""
        self._line: asyncio.Transport | None = None
        """The connection, even before the hub has accepted this member."""
        self._records = Records()
        self._is_on = True
        self._offset_ns = 0  # our clock less the hub's: 0 on one machine
        self._challenge: asyncio.Future[str] | None = None
        self._welcome: asyncio.Future[None] | None = None

    def send(self, message: Any) -> None:
        try:
            self._check(message)
        except (TypeError, ValueError) as cause:
            raise unsendable(cause, self._member, self._bus.name, message) from cause
        data = self._encode(message)
        standing = None if self._standing_of is None else self._standing_of(message)
        if standing is not None and (standing in self._standing or len(self._standing) < MOST_STANDING):
            self._standing[standing] = data
        if self._transport is None:
            log.debug("%s: %s has no hub; not sent: %r", self._bus.name, self._member, message)
            return
        self._transport.write(pack(Kind.MESSAGE, self._clock.now_ns() - self._offset_ns, data))

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        try:
            self._bus.check_interest(interest)
        except (TypeError, ValueError) as cause:
            raise uninteresting(cause, self._member, self._bus.name, interest) from cause
        self._handler, self._interest = handler, interest
        self._listen()

    def switch(self, is_on: bool) -> None:
        """Tell the hub that the device of this end has no power, or has it again."""
        self._is_on = is_on
        self._standing.clear()
        self._tell_power()

    def _tell_power(self) -> None:
        if self._transport is not None:
            self._transport.write(pack(Kind.POWER, time.monotonic_ns(), json.dumps(self._is_on).encode()))

    def note(self, fault: FaultNote) -> None:
        """Add a fault of the device to the trace of the bus; it is lost while there is no hub."""
        if self._transport is not None:
            self._transport.write(pack(Kind.NOTE, self._clock.now_ns() - self._offset_ns, note.encode(fault)))

    async def connect(self) -> None:
        """Attach to the hub.  BusError if there is none, or if it refuses."""
        loop = asyncio.get_running_loop()
        self._challenge, self._welcome = loop.create_future(), loop.create_future()
        self._records = Records()
        address = self._bus.connect or self._bus.attach
        path = self._run / socket_name(self._bus)
        try:
            if self._bus.connect is None and path.exists():
                transport, _ = await loop.create_unix_connection(lambda: self, str(path))
            elif address is not None:
                host, port = split_address(address)
                async with asyncio.timeout(CONNECT_S):
                    transport, _ = await loop.create_connection(lambda: self, host, port)
            else:
                raise FileNotFoundError(f"no socket {path}")
        except OSError as cause:
            raise BusError(
                f"{self._bus.name}: no hub answers: {cause or f'within {CONNECT_S:g} s'}",
                "start the process that runs this bus first",
            ) from cause
        try:
            hello = self._hello(await self._challenge)
            transport.write(pack(Kind.HELLO, time.monotonic_ns(), json.dumps(hello).encode()))
            await self._welcome
        except BaseException:
            transport.abort()
            raise
        self._transport = transport
        if not self._is_on:
            self._tell_power()
        if self._handler is not None:
            self._listen()
        for data in self._standing.values():
            transport.write(pack(Kind.MESSAGE, time.monotonic_ns() - self._offset_ns, data))

    async def close(self) -> None:
        if self._transport is not None:
            self._transport.close()
            self._transport = None

    def data_received(self, data: bytes) -> None:
        handle_at, decode, offset_ns = self._clock.handle_at, self._decode, self._offset_ns
        records = self._records.feed(data)
        while True:
            try:
                kind, instant_ns, body = next(records)
                if kind == Kind.MESSAGE:
                    message = decode(body)
                else:
                    self._on_answer(kind, read_json(body))
            except StopIteration:
                return
            except ValueError as fault:
                self._hang_up(f"what the hub said cannot be understood: {fault}")
                return
            if kind == Kind.MESSAGE and self._handler is not None:
                try:
                    handle_at(instant_ns + offset_ns, self._handler, message)
                except Exception as fault:
                    blame(fault, self._member, self._bus.name, instant_ns + offset_ns)
                    raise

    def connection_made(self, transport: Any) -> None:
        self._line = transport
        leave_when_silent(transport)

    def connection_lost(self, cause: Exception | None) -> None:
        was_attached, self._transport, self._line = self._transport is not None, None, None
        self._fail(f"the hub closed the line: {cause}")
        if was_attached:
            self._on_lost(f"{self._bus.name}: the hub is gone")

    def _hello(self, nonce: str) -> dict[str, str]:
        bus, member, secret = self._bus.name, self._member, token()
        hello = {"bus": bus, "member": member}
        return hello if secret is None else {**hello, "proof": proof(secret, nonce, bus, member)}

    def _on_answer(self, kind: int, answer: Any) -> None:
        if kind == Kind.REFUSED:
            why = field(answer, "why", str)
            if self._transport is not None:
                log.error("%s: the hub disconnects %s: %s", self._bus.name, self._member, shown(why))
            self._fail(why)
        elif kind == Kind.CHALLENGE and self._challenge is not None and not self._challenge.done():
            self._challenge.set_result(field(answer, "nonce", str))
        elif kind == Kind.HELLO and self._welcome is not None and not self._welcome.done():
            offset_ns = time.monotonic_ns() - field(answer, "now_ns", int)
            # Clocks of one machine agree; another machine's may be off by its whole time since boot.
            self._offset_ns = offset_ns if abs(offset_ns) > S else 0
            self._welcome.set_result(None)

    def _fail(self, why: str) -> None:
        """End every wait for an answer of the hub."""
        for awaited in (self._challenge, self._welcome):
            if awaited is not None and not awaited.done():
                awaited.set_exception(BusError(f"{self._bus.name}: {why}"))
                awaited.exception()  # only one of them is looked at

    def _hang_up(self, why: str) -> None:
        log.warning("%s: %s: %s", self._bus.name, self._member, why)
        self._fail(why)
        if self._line is not None:
            self._line.abort()

    def _listen(self) -> None:
        if self._transport is not None:
            body = json.dumps(None if self._interest is None else list(self._interest)).encode()
            self._transport.write(pack(Kind.LISTEN, time.monotonic_ns(), body))


class OutsidersLink(Portions, RemoteLink):
    """A link for requests of outsiders, which are read at the pace of the process."""

    def __init__(
        self, bus: ModelBus[Any], member: str, clock: RealClock, run: Path, on_lost: Callable[[str], None]
    ) -> None:
        Portions.__init__(self)
        RemoteLink.__init__(self, bus, member, clock, run, on_lost)

    def data_received(self, data: bytes) -> None:
        RemoteLink.data_received(self, data)

    def connection_made(self, transport: Any) -> None:
        super().connection_made(transport)
        self._unseen = b""  # of a former hub
        self.read_from_now(self._is_reading)

    def read_from_now(self, is_wanted: bool) -> None:
        if self._line is None or self._line.is_closing():
            return
        if is_wanted:
            self._line.resume_reading()
        else:
            self._line.pause_reading()


async def attach(
    bus: ModelBus[Any], member: str, clock: RealClock, run: Path, on_lost: Callable[[str], None]
) -> RemoteLink:
    """Return a link to a running hub.  BusError, with its remedy, if there is none."""
    link = RemoteLink(bus, member, clock, run, on_lost)
    await link.connect()
    return link
