"""The connections of browsers: how many there are, and how long one may stay without a request.

Uvicorn keeps a connection that never sends anything, so a thousand of them would keep every browser out.
"""

import asyncio
from typing import Any, ClassVar, Final

from uvicorn.protocols.http.h11_impl import H11Protocol

from fieldrig.outside.limits import Door, Limits

LIMITS: Final = Limits(connections=256, silent=64, first_message_s=10.0, replaces_idle=False)


class Connection(H11Protocol):
    """A connection for HTTP, until it becomes a socket of the page, which has limits of its own (`live`)."""

    door: ClassVar[Door] = Door("page", LIMITS)

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self.door.expire()
        peer = self.client[0] if self.client else ""
        if not self.door.is_open_to(peer):
            transport.abort()
            return
        self.door.enter(self, peer)

    def handle_events(self) -> None:
        super().handle_events()
        if self.cycle is not None:  # a request has come
            self.door.heard(self)

    def handle_websocket_upgrade(self, event: Any) -> None:
        self.door.leave(self)
        super().handle_websocket_upgrade(event)

    def connection_lost(self, exc: Exception | None) -> None:
        self.door.leave(self)
        super().connection_lost(exc)

    @property
    def is_pending(self) -> bool:
        """False: what a browser sends is read as it arrives."""
        return False

    def shut(self) -> None:
        """Close the connection at once."""
        self.transport.abort()
