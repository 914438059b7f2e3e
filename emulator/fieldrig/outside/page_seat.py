"""The seat of the page of a rig: its listening socket, and the tokens of its addresses.

The process that starts the rig takes the seat and keeps it, and the page's process inherits it.  So the address and the
cookies of open pages stay the same when that process dies and is started again.
"""

import errno
import hashlib
import hmac
import json
import os
import secrets
import socket
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final, Literal, Self

from fieldrig.errors import BusError, RigError
from fieldrig.outside.addresses import bind_remedy, is_loopback, split_address
from fieldrig.outside.shared_token import FILE_VARIABLE, TOKEN_VARIABLE, make_token, token

DEFAULT_PAGE: Final = "127.0.0.1:8372"
"""The address of the page, unless a rig file has another; a free port is used if this one is taken."""
BACKLOG: Final = 128
"""Connections that wait while the page's process starts."""
_BYTES: Final = 16

PageRole = Literal["operate", "look"]
ROLES: Final[tuple[PageRole, ...]] = ("operate", "look")


@dataclass(frozen=True, slots=True)
class Seat:
    """A listening socket for the page, and who may come in."""

    listener: socket.socket
    hosts: tuple[str, ...] = ()
    """Further names of the page, as host:port; the first is the one that is printed."""
    tokens: dict[PageRole, str] = field(default_factory=lambda: {role: _token_for(role) for role in ROLES})

    @property
    def address(self) -> tuple[str, int]:
        """Host and port where it listens."""
        host, port = self.listener.getsockname()[:2]
        return str(host), int(port)

    def addresses(self) -> dict[PageRole, str]:
        """Return the address of the page for each role, with its token."""
        host, port = self.address
        name = host if is_loopback(host) else "127.0.0.1"
        place = self.hosts[0] if self.hosts else f"[{name}]:{port}" if ":" in name else f"{name}:{port}"
        return {role: f"http://{place}/?token={secret}" for role, secret in self.tokens.items()}

    def to_text(self) -> str:
        """Return everything but the socket, for the process that inherits it."""
        return json.dumps({"hosts": self.hosts, "tokens": self.tokens})

    @classmethod
    def from_text(cls, text: str, descriptor: int) -> Self:
        """Return the seat of `to_text` with an inherited socket."""
        parts = json.loads(text)
        return cls(socket.socket(fileno=descriptor), tuple(parts["hosts"]), parts["tokens"])

    def close(self) -> None:
        self.listener.close()


def take_seat(listen: str | None, hosts: Sequence[str] = ()) -> Seat:
    """Return a seat at `listen`, as host:port, or without one at `DEFAULT_PAGE` or a free port if that is taken.

    BusError if the address is not available.  RigError beyond loopback without a token.
    """
    make_token()
    host, port = split_address(listen if listen is not None else DEFAULT_PAGE)
    if not is_loopback(host) and token() is None:
        raise RigError(
            f"ui.listen {listen} can be reached from other machines",
            f"set a token in the environment variable {TOKEN_VARIABLE}, or name a file for it in {FILE_VARIABLE},"
            f" or listen on {DEFAULT_PAGE}",
        )
    try:
        return Seat(_listener(host, port), tuple(hosts))
    except OSError as cause:
        if listen is None and cause.errno == errno.EADDRINUSE:
            return Seat(_listener(host, 0), tuple(hosts))
        raise BusError(f"the page cannot listen on {host}:{port}: {cause.strerror}", bind_remedy(cause)) from cause


def _listener(host: str, port: int) -> socket.socket:
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    listener = socket.create_server((host, port), family=family, backlog=BACKLOG, reuse_port=False)
    listener.setblocking(False)
    return listener


def _token_for(role: PageRole) -> str:
    """Return the token of a role: from the token of the rig if it has one, so that it stays the same, or by chance."""
    secret = token()
    if secret is None:
        return secrets.token_urlsafe(_BYTES)
    return hmac.new(secret.encode(), f"page/{role}".encode(), hashlib.sha256).hexdigest()[: 2 * _BYTES]


NO_PAGE_VARIABLE: Final = "FIELDRIG_NO_UI"
"""Environment variable that leaves the page out, as `fieldrig up --no-ui` does."""
SEAT_VARIABLE: Final = "FIELDRIG_PAGE_SEAT"
"""Environment variable of the page's process: its seat, as `Seat.to_text` writes it."""


def inherited_seat(descriptor: int) -> Seat:
    """Return the seat that the parent has left in the environment, and take it out there."""
    return Seat.from_text(os.environ.pop(SEAT_VARIABLE), descriptor)
