"""The hub's end of the streams to members in other processes (`hub_wire` has the records)."""

import asyncio
import json
import logging
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fieldrig.bus import Delivery
from fieldrig.errors import BusError
from fieldrig.hub_wire import Kind, Records, pack, socket_name
from fieldrig.net import bind_remedy, split_address

if TYPE_CHECKING:
    from fieldrig.hub import LocalHub

log = logging.getLogger(__name__)

SLOWEST_BACKLOG = 4 << 20  # bytes; a member that reads no more is put off the bus rather than filling the memory


class HubServer:
    def __init__(self, hub: "LocalHub") -> None:
        self._hub = hub
        self._servers: list[asyncio.Server] = []
        self._path = hub.path(socket_name(hub.bus))
        self.streams: set[MemberStream] = set()
        self._loop = asyncio.get_running_loop()
        self._awake_ns = hub.bus.awake_ns
        self._sleep_at_ns = 0

    async def open(self) -> None:
        """BusError if a socket can't be had."""
        loop, bus = asyncio.get_running_loop(), self._hub.bus
        if hasattr(asyncio, "open_unix_connection"):
            # The rig's lock says that no living rig owns this folder: what lies here is left from a killed one.
            try:
                self._path.unlink(missing_ok=True)
                self._servers.append(await loop.create_unix_server(self._stream, str(self._path)))
            except OSError as cause:
                remedy = "make room there, or name another run folder: --set run=FOLDER"
                raise BusError(f"{bus.name}: {self._path} can't be made: {cause.strerror}", remedy) from cause
        if bus.attach is not None:
            host, port = split_address(bus.attach)
            try:
                self._servers.append(await loop.create_server(self._stream, host, port))
            except OSError as cause:
                raise BusError(f"{bus.name}: can't listen on {bus.attach}: {cause}", bind_remedy(cause)) from cause

    async def close(self) -> None:
        for server in self._servers:
            server.close()
        for stream in tuple(self.streams):
            stream.abort()
        for server in self._servers:
            await server.wait_closed()
        self._servers.clear()
        self._path.unlink(missing_ok=True)

    def stay_awake(self) -> None:
        """Look for the next message for a while before sleeping, where the bus says that one follows at once."""
        if self._awake_ns:
            is_asleep = self._sleep_at_ns == 0
            self._sleep_at_ns = time.monotonic_ns() + self._awake_ns
            if is_asleep:
                self._loop.call_soon(self._look_again)

    def _look_again(self) -> None:
        if time.monotonic_ns() < self._sleep_at_ns:
            self._loop.call_soon(self._look_again)
        else:
            self._sleep_at_ns = 0

    def _stream(self) -> "MemberStream":
        return MemberStream(self._hub, self)


class MemberStream(asyncio.Protocol):
    """One member in another process."""

    def __init__(self, hub: "LocalHub", server: HubServer) -> None:
        self._hub, self._server = hub, server
        self._records = Records()
        self._member: str | None = None
        self._transport: asyncio.Transport | None = None
        self._encode = hub.bus.encode
        self._decode = hub.bus.decode

    def connection_made(self, transport: Any) -> None:
        self._transport = transport
        self._server.streams.add(self)
        transport.set_write_buffer_limits(high=SLOWEST_BACKLOG)

    def connection_lost(self, _cause: Exception | None) -> None:
        self._server.streams.discard(self)
        if self._member is not None:
            self._hub.leave(self._member)

    def pause_writing(self) -> None:
        log.warning("%s: %s does not read; put off the bus", self._hub.bus.name, self._member)
        self.abort()

    def abort(self) -> None:
        if self._transport is not None:
            self._transport.abort()

    def data_received(self, data: bytes) -> None:
        hub, member, decode = self._hub, self._member, self._decode
        try:
            for kind, instant_ns, body in self._records.feed(data):
                if kind == Kind.MESSAGE and member is not None:
                    hub.submit_late(instant_ns, member, decode(body))
                elif kind == Kind.LISTEN and member is not None:
                    hub.listen(member, _interest(body))
                elif kind == Kind.HELLO and member is None:
                    member = self._greet(body)
                else:
                    raise ValueError(f"record of kind {kind} out of place")
        except ValueError as fault:
            log.warning("%s: %s is put off the bus: %s", hub.bus.name, member, fault)
            self.abort()
        hub.carry()
        self._server.stay_awake()

    def deliver(self, delivery: Delivery[Any]) -> None:
        if self._transport is not None:
            self._transport.write(pack(Kind.MESSAGE, delivery.time_ns, self._encode(delivery.message)))

    def _greet(self, body: bytes) -> str:
        hello = json.loads(body)
        if not isinstance(hello, dict) or not isinstance(member := hello.get("member"), str):
            raise ValueError("a hello without a member's name")
        try:
            if hello.get("bus") != self._hub.bus.name:
                raise ValueError(f"this is {self._hub.bus.name}, not {hello.get('bus')}")
            self._hub.join_as(member, self.deliver)
        except ValueError as fault:
            self._write(Kind.REFUSED, {"why": str(fault)})
            raise
        self._member = member
        self._write(Kind.HELLO, {"now_ns": time.monotonic_ns()})
        return member

    def _write(self, kind: Kind, body: Any) -> None:
        if self._transport is not None:
            self._transport.write(pack(kind, time.monotonic_ns(), json.dumps(body).encode()))


def _interest(body: bytes) -> Sequence[Any] | None:
    interest = json.loads(body)
    if interest is not None and not isinstance(interest, list):
        raise ValueError("an interest that is not a list")
    return interest
