"""The hub's end of the streams to members in other processes (`wire.py` has the records)."""

import asyncio
import json
import logging
import secrets
import time
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from fieldrig.bus import Delivery
from fieldrig.errors import BusError
from fieldrig.faults import note
from fieldrig.faults.note import FaultNote
from fieldrig.hub.wire import LONGEST_BODY, LONGEST_HELLO, LONGEST_NAME, Kind, Records, pack, socket_name
from fieldrig.outside.addresses import bind_remedy, is_loopback, split_address
from fieldrig.outside.limits import Door, Limits
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, is_proof, token
from fieldrig.outside.untrusted import field, read_json, shown
from fieldrig.outside.vanished import leave_when_silent
from fieldrig.system.own_files import remove_socket

if TYPE_CHECKING:
    from fieldrig.hub.hub import LocalHub

log = logging.getLogger(__name__)

LONGEST_WHY = 300  # characters
PATIENCE_S = 10.0
"""Time limit for the hello on a new connection."""
LIMITS = Limits(connections=8192, first_message_s=PATIENCE_S, silent=256)
"""Connections of members; one more without a hello than these closes the one that was silent longest."""
CROWDED_BACKLOG = 64 << 10
"""Bytes that a member has not read yet, from which on outsiders have to wait."""
SLOWEST_BACKLOG = 4 << 20  # bytes; a member that stops reading is disconnected, so that it cannot fill the memory


class HubServer:
    def __init__(self, hub: "LocalHub") -> None:
        self._hub = hub
        self._servers: list[asyncio.Server] = []
        self._path = hub.path(socket_name(hub.bus))
        self.streams: set[MemberStream] = set()
        self.door = Door(f"{hub.bus.name}: its hub", LIMITS)
        self._loop = asyncio.get_running_loop()
        self._awake_ns = hub.bus.awake_ns
        self._sleep_at_ns = 0

    async def open(self) -> None:
        """Open the sockets.  BusError if one is not available, or if processes outside the rig could attach."""
        loop, bus = asyncio.get_running_loop(), self._hub.bus
        if hasattr(asyncio, "open_unix_connection"):
            # The lock shows that no running rig owns this folder, so a socket here is left over from a killed one.
            try:
                remove_socket(self._path)
                self._servers.append(await loop.create_unix_server(lambda: self._stream(None), str(self._path)))
            except OSError as cause:
                remedy = "make room there, or name another run folder: --set run=FOLDER"
                raise BusError(f"{bus.name}: {self._path} cannot be made: {cause.strerror or cause}", remedy) from cause
        if bus.attach is not None:
            host, port = split_address(bus.attach)
            secret = token()
            if secret is None and not is_loopback(host):
                raise BusError(
                    f"{bus.name}: {bus.attach} can be reached from other machines",
                    f"set a token in the environment variable {TOKEN_VARIABLE}, for this process and for those that"
                    f" attach, or name a file for it in {FILE_VARIABLE}, or attach at 127.0.0.1",
                )
            try:
                self._servers.append(await loop.create_server(lambda: self._stream(secret), host, port))
            except OSError as cause:
                raise BusError(f"{bus.name}: cannot listen on {bus.attach}: {cause}", bind_remedy(cause)) from cause

    def statistics(self) -> dict[str, float]:
        """Return how often each limit of the connections of members was reached."""
        return self.door.reached.figures()

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
        """Poll for the next message for a while, if the bus expects it at once."""
        if self._awake_ns:
            is_asleep = self._sleep_at_ns == 0
            self._sleep_at_ns = time.monotonic_ns() + self._awake_ns
            if is_asleep:
                self._loop.call_soon(self._poll)

    def _poll(self) -> None:
        if time.monotonic_ns() < self._sleep_at_ns:
            self._loop.call_soon(self._poll)
        else:
            self._sleep_at_ns = 0

    def _stream(self, secret: str | None) -> "MemberStream":
        return MemberStream(self._hub, self, secret)


class MemberStream(asyncio.Protocol):
    """One member in another process.

    A malformed or unexpected record disconnects this member, with a reason, and no other.
    """

    def __init__(self, hub: "LocalHub", server: HubServer, secret: str | None = None) -> None:
        """`secret` is the token that the member must know, or None."""
        self._hub, self._server, self._secret = hub, server, secret
        self._records = Records(LONGEST_HELLO)
        self._nonce = secrets.token_hex(16)
        self._patience: asyncio.TimerHandle | None = None
        self._member: str | None = None
        self._transport: asyncio.Transport | None = None
        self._is_crowded = False
        self._encode = hub.bus.encode
        self._decode = hub.bus.decode

    def connection_made(self, transport: Any) -> None:
        self._transport = transport
        address = transport.get_extra_info("peername")
        peer = address[0] if isinstance(address, tuple) else ""  # a Unix socket has none
        if not self._server.door.is_open_to(peer):
            self.abort()
            return
        self._server.door.enter(self, peer)
        self._server.streams.add(self)
        leave_when_silent(transport)
        transport.set_write_buffer_limits(high=CROWDED_BACKLOG)
        self._write(Kind.CHALLENGE, {"nonce": self._nonce})
        self._patience = asyncio.get_running_loop().call_later(PATIENCE_S, self._disconnect, "no hello came")

    def connection_lost(self, _cause: Exception | None) -> None:
        self._server.streams.discard(self)
        self._server.door.leave(self)
        self._hub.crowd(self, False)
        if self._patience is not None:
            self._patience.cancel()
        if self._member is not None:
            self._hub.leave(self._member)

    def pause_writing(self) -> None:
        self._is_crowded = True
        self._hub.crowd(self, True)

    def resume_writing(self) -> None:
        self._is_crowded = False
        self._hub.crowd(self, False)

    @property
    def is_pending(self) -> bool:
        """False: what a member sends is handled as it arrives."""
        return False

    def shut(self) -> None:
        self._disconnect("too many connections without a hello")

    def abort(self) -> None:
        """Close the connection.  Buffered bytes are tried once more, and nothing is read."""
        transport, self._transport = self._transport, None
        if transport is not None:
            transport.abort()

    def data_received(self, data: bytes) -> None:
        hub, member, decode = self._hub, self._member, self._decode
        records = self._records.feed(data)
        while self._transport is not None:
            # Only what reads the member's own bytes is in here: a ValueError of the hub, or of a device, is our own.
            try:
                kind, instant_ns, body = next(records)
                if kind == Kind.MESSAGE and member is not None:
                    message = decode(body)
                    if isinstance(message, FaultNote):
                        raise ValueError("the note of a fault is no message of a member")
                elif kind == Kind.LISTEN and member is not None:
                    interest = self._interest(body)
                elif kind == Kind.POWER and member is not None:
                    is_on = self._power(body)
                elif kind == Kind.NOTE and member is not None:
                    noted = note.decode(body)
                elif kind == Kind.HELLO and member is None:
                    member = self._greet(body)
                else:
                    raise ValueError(f"a record of kind {kind} is out of place")
            except StopIteration:
                break
            except (TypeError, ValueError) as fault:
                self._disconnect(str(fault))
                break
            if kind == Kind.MESSAGE:
                hub.submit_late(instant_ns, member, message)
            elif kind == Kind.LISTEN:
                hub.listen(member, interest)
            elif kind == Kind.POWER:
                hub.switch(member, is_on)
            elif kind == Kind.NOTE:
                hub.note(member, noted)
        hub.carry()
        self._server.stay_awake()

    def deliver(self, delivery: Delivery[Any]) -> None:
        if self._transport is not None:
            self._transport.write(pack(Kind.MESSAGE, delivery.time_ns, self._encode(delivery.message)))
            if self._is_crowded and self._transport.get_write_buffer_size() > SLOWEST_BACKLOG:
                log.warning("%s: %s does not read; disconnected", self._hub.bus.name, self._member)
                self.abort()

    def _greet(self, body: bytes) -> str:
        hello, own_bus = read_json(body), self._hub.bus.name
        member, bus = field(hello, "member", str), field(hello, "bus", str)
        if not 1 <= len(member) <= LONGEST_NAME or not member.isprintable():
            raise ValueError(f"{shown(member)} is not the name of a member")
        if bus != own_bus:
            raise ValueError(f"this hub runs the bus {own_bus}, not {shown(bus)}")
        if self._secret is not None:
            given = field(hello, "proof", str) if "proof" in hello else ""
            if not is_proof(given, self._secret, self._nonce, bus, member):
                raise ValueError(f"this hub asks for the rig's token: set {TOKEN_VARIABLE} to the rig's")
        self._hub.join_as(member, self.deliver)
        self._member = member
        self._server.door.heard(self)
        self._records.longest = LONGEST_BODY
        if self._patience is not None:
            self._patience.cancel()
        self._write(Kind.HELLO, {"now_ns": time.monotonic_ns()})
        return member

    def _write(self, kind: Kind, body: Any) -> None:
        if self._transport is not None:
            self._transport.write(pack(kind, time.monotonic_ns(), json.dumps(body).encode()))

    def _power(self, body: bytes) -> bool:
        is_on = read_json(body)
        if not isinstance(is_on, bool):
            raise ValueError(f"expected true or false for the power of a device, found {shown(is_on)}")
        return is_on

    def _interest(self, body: bytes) -> Sequence[Any] | None:
        interest: Sequence[Any] | None = read_json(body)
        self._hub.bus.check_interest(interest)
        return interest

    def _disconnect(self, why: str) -> None:
        log.warning("%s: %s is disconnected: %s", self._hub.bus.name, self._member or "an unknown client", _brief(why))
        self._write(Kind.REFUSED, {"why": _brief(why)})
        self.abort()


def _brief(why: str) -> str:
    return why if len(why) <= LONGEST_WHY else f"{why[:LONGEST_WHY]}..."
