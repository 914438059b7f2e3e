"""A device's end of a bus whose hub runs in another process."""

import asyncio
import json
import logging
import time
from collections.abc import Callable, Hashable, Sequence
from pathlib import Path
from typing import Any

from fieldrig.blame import blame
from fieldrig.bus import ModelBus
from fieldrig.clock import S
from fieldrig.errors import BusError
from fieldrig.hub_wire import Kind, Records, pack, socket_name
from fieldrig.net import split_address
from fieldrig.real_clock import RealClock

log = logging.getLogger(__name__)

MOST_STANDING = 4_096
"""Messages that are kept for a new hub; a hub takes no more of one member."""


class RemoteLink(asyncio.Protocol):
    """Keeps handler and interest over a lost hub; `connect` again when it is back.

    Between, nothing is carried; where messages hold (see `ModelBus.standing_of`) the last ones are said then.
    """

    def __init__(
        self, bus: ModelBus[Any], member: str, clock: RealClock, run: Path, on_lost: Callable[[str], None]
    ) -> None:
        self._bus, self._member, self._clock, self._run, self._on_lost = bus, member, clock, run, on_lost
        self._encode, self._decode = bus.encode, bus.decode
        self._standing_of, self._standing = bus.standing_of, dict[Hashable, bytes]()
        self._handler: Callable[[Any], None] | None = None
        self._interest: Sequence[object] | None = None
        self._transport: asyncio.Transport | None = None
        self._records = Records()
        self._offset_ns = 0  # our clock less the hub's: 0 on one machine
        self._welcome: asyncio.Future[None] | None = None

    def send(self, message: Any) -> None:
        data = self._encode(message)
        standing = None if self._standing_of is None else self._standing_of(message)
        if standing is not None and (standing in self._standing or len(self._standing) < MOST_STANDING):
            self._standing[standing] = data
        if self._transport is None:
            log.debug("%s: %s has no hub; not sent: %r", self._bus.name, self._member, message)
            return
        self._transport.write(pack(Kind.MESSAGE, self._clock.now_ns() - self._offset_ns, data))

    def on_receive(self, handler: Callable[[Any], None], interest: Sequence[object] | None = None) -> None:
        self._handler, self._interest = handler, interest
        self._listen()

    async def connect(self) -> None:
        """Attach to the hub.  BusError if it is not there, or refuses."""
        loop = asyncio.get_running_loop()
        self._welcome = loop.create_future()
        self._records = Records()
        address = getattr(self._bus.settings, "connect", None) or self._bus.attach
        path = self._run / socket_name(self._bus)
        try:
            if getattr(self._bus.settings, "connect", None) is None and path.exists():
                transport, _ = await loop.create_unix_connection(lambda: self, str(path))
            elif address is not None:
                host, port = split_address(address)
                transport, _ = await loop.create_connection(lambda: self, host, port)
            else:
                raise FileNotFoundError(f"no socket {path}")
        except OSError as cause:
            raise BusError(
                f"{self._bus.name}: no hub answers: {cause}", "start the process that runs this bus first"
            ) from cause
        hello = {"bus": self._bus.name, "member": self._member}
        transport.write(pack(Kind.HELLO, time.monotonic_ns(), json.dumps(hello).encode()))
        try:
            await self._welcome
        except BusError:
            transport.abort()
            raise
        self._transport = transport
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
        for kind, instant_ns, body in self._records.feed(data):
            if kind == Kind.MESSAGE:
                if self._handler is not None:
                    message = decode(body)
                    try:
                        handle_at(instant_ns + offset_ns, self._handler, message)
                    except Exception as fault:
                        blame(fault, self._member, self._bus.name, instant_ns + offset_ns)
                        raise
            elif self._welcome is not None and not self._welcome.done():
                self._on_answer(kind, json.loads(body))

    def connection_lost(self, cause: Exception | None) -> None:
        was_attached, self._transport = self._transport is not None, None
        if self._welcome is not None and not self._welcome.done():
            self._welcome.set_exception(BusError(f"{self._bus.name}: the hub closed the line: {cause}"))
        elif was_attached:
            self._on_lost(f"{self._bus.name}: the hub is gone")

    def _on_answer(self, kind: int, answer: dict[str, Any]) -> None:
        assert self._welcome is not None
        if kind == Kind.HELLO:
            offset_ns = time.monotonic_ns() - int(answer["now_ns"])
            # Clocks of one machine agree; another machine's may be off by its whole time since boot.
            self._offset_ns = offset_ns if abs(offset_ns) > S else 0
            self._welcome.set_result(None)
        else:
            self._welcome.set_exception(BusError(f"{self._bus.name}: {answer.get('why', 'refused')}"))

    def _listen(self) -> None:
        if self._transport is not None:
            body = json.dumps(None if self._interest is None else list(self._interest)).encode()
            self._transport.write(pack(Kind.LISTEN, time.monotonic_ns(), body))


async def attach(
    bus: ModelBus[Any], member: str, clock: RealClock, run: Path, on_lost: Callable[[str], None]
) -> RemoteLink:
    """A link to a hub that runs.  BusError, with its remedy, if it doesn't."""
    link = RemoteLink(bus, member, clock, run, on_lost)
    await link.connect()
    return link
