"""The sockets of the page: what each wants to see, and frames of it up to 30 times a second.

A page acknowledges what it has got.  One that is `MOST_UNSEEN` ticks behind gets nothing more until it has caught up,
and then everything again: a reader that stands still takes no memory here, however much its socket buffers.
"""

import asyncio
import logging
from collections.abc import Sequence
from contextlib import suppress
from typing import Any, ClassVar, Final, Literal, Protocol

from starlette.websockets import WebSocket, WebSocketDisconnect

from fieldrig.outside.limits import OVER_LIMIT
from fieldrig.outside.untrusted import MalformedError, field
from fieldrig_page.connections import Connection
from fieldrig_page.wire import packed, taken

log = logging.getLogger(__name__)

Role = Literal["look", "operate"]

FRAME_S: Final = 1 / 30
MOST_UNSEEN: Final = 3
"""Ticks that a page may be behind."""
MOST_SOCKETS: Final = 64
"""Sockets at a time."""
UNSUPPORTED: Final = 1003
"""Close code for a message that is not understood (RFC 6455, 7.4.1)."""
LONGEST_REASON: Final = 123
"""Longest reason of a close in bytes (RFC 6455, 5.5)."""
FAULT: Final = 1011
"""Close code for a fault of the server (RFC 6455, 7.4.1)."""


class Page:
    """One browser that looks: its socket, and how far it has come with reading."""

    def __init__(self, role: Role) -> None:
        self.role = role
        self.wishes: dict[str, Any] = {}
        """The request that it made of each topic."""
        self.is_behind = False
        self._sent = self._seen = 0
        self._waiting: asyncio.Queue[bytes] = asyncio.Queue()

    @property
    def may_be_sent(self) -> bool:
        return self._sent - self._seen < MOST_UNSEEN

    def send(self, messages: Sequence[Any]) -> None:
        """Send the messages of one tick.  At most `MOST_UNSEEN` wait here, as nothing is sent to one that is behind."""
        self._sent += 1
        self._waiting.put_nowait(packed(self._sent, messages))

    def on_seen(self, number: int) -> None:
        """Take an acknowledgement.  MalformedError for a tick that was never sent."""
        if not 0 < number <= self._sent:
            raise MalformedError(f"tick {number} was not sent")
        self._seen = max(self._seen, number)

    async def next(self) -> bytes:
        return await self._waiting.get()


class Topic(Protocol):
    """Something that pages look at."""

    name: ClassVar[str]

    def want(self, page: Page, wish: Any) -> None:
        """Show the page this from now on, beginning with the whole of it, or nothing more if it is None.

        MalformedError for a request that is not understood closes only this socket, with the reason.
        """

    def forget(self, page: Page) -> None:
        """Forget a page that has gone, or that wants nothing more; it may never have wanted anything."""

    def frame(self, page: Page) -> Any | None:
        """Return what is new for the page since the last frame, as a map; None if nothing is.

        Called up to 30 times a second for each page that wants something.
        """

    async def run(self) -> None:
        """Do the topic's own work for the life of the process."""


class Live:
    """All sockets of the page."""

    def __init__(self, topics: Sequence[Topic], greeting: dict[str, Any]) -> None:
        """`greeting` is the first message of every socket; the role of the page is added to it."""
        self.pages: dict[Page, WebSocket] = {}
        self.left_out = 0
        """Ticks that were left out because a page was behind."""
        self._topics = {topic.name: topic for topic in topics}
        self._greeting = greeting

    async def run(self) -> None:
        """Send frames for the life of the process.  After a stall it goes on from the present."""
        loop = asyncio.get_running_loop()
        due_s = loop.time()
        while True:
            for page, socket in tuple(self.pages.items()):
                try:
                    self.tick(page)
                except Exception:
                    log.exception("a fault in a topic; only the socket that wanted it is closed")
                    self.pages.pop(page, None)
                    await _close(socket, FAULT)
            due_s = max(due_s + FRAME_S, loop.time())
            await asyncio.sleep(due_s - loop.time())

    def tick(self, page: Page) -> None:
        """Send the page what is new for it, unless it is behind."""
        if not page.may_be_sent:
            page.is_behind = True
            self.left_out += 1
            return
        if page.is_behind:
            page.is_behind = False
            for name, wish in page.wishes.items():
                self._topics[name].want(page, wish)  # its next frame is whole
        frames = ((name, self._topics[name].frame(page)) for name in page.wishes)
        messages = [{"t": name, **frame} for name, frame in frames if frame is not None]
        if messages:
            page.send(messages)

    async def serve(self, socket: WebSocket) -> None:
        """Serve one socket to its end."""
        if len(self.pages) >= MOST_SOCKETS:
            Connection.door.reached.note(OVER_LIMIT, f"{MOST_SOCKETS} pages are open; another one is refused")
            await socket.close()  # before it is accepted: HTTP status 403
            return
        page = Page(socket.scope["role"])
        page.send([{"t": "hello", "role": page.role, **self._greeting}])
        self.pages[page] = socket  # before it is accepted, so that sockets at the same instant are counted
        sending: asyncio.Task[None] | None = None
        try:
            await socket.accept()
            sending = asyncio.get_running_loop().create_task(_send_all(page, socket))
            while True:
                self.take(page, await _received(socket))
        except MalformedError as cause:
            log.info("a socket is closed: %s", cause)
            await _close(socket, UNSUPPORTED, str(cause))
        except WebSocketDisconnect:
            pass
        finally:
            self.pages.pop(page, None)
            if sending is not None:
                sending.cancel()
            for topic in self._topics.values():
                topic.forget(page)

    def take(self, page: Page, data: bytes) -> None:
        """Take a message of a page.  MalformedError for anything that is not understood."""
        message = taken(data)
        match field(message, "t", str):
            case "seen":
                page.on_seen(field(message, "number", int))
            case "want":
                name = field(message, "topic", str)
                if name not in self._topics:
                    raise MalformedError(f"there is no topic {name!r:.60}")
                self._want(page, name, message.get("wish"))
            case other:
                raise MalformedError(f"there is no message {other!r:.60}")

    def _want(self, page: Page, name: str, wish: Any) -> None:
        if wish is None:
            page.wishes.pop(name, None)
            self._topics[name].forget(page)
        else:
            try:
                self._topics[name].want(page, wish)
            except MalformedError as cause:
                raise MalformedError(f"{name}: {cause}") from cause
            page.wishes[name] = wish


async def _received(socket: WebSocket) -> bytes:
    message = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1000))
    data = message.get("bytes")
    if data is None:
        raise MalformedError("expected a binary message")
    return bytes(data)


async def _send_all(page: Page, socket: WebSocket) -> None:
    with suppress(WebSocketDisconnect, RuntimeError):  # it has gone; who receives notices that too
        while True:
            await socket.send_bytes(await page.next())


async def _close(socket: WebSocket, code: int, reason: str = "") -> None:
    shortened = reason.encode()[:LONGEST_REASON].decode(errors="ignore")
    with suppress(WebSocketDisconnect, RuntimeError):  # it has gone by itself
        await socket.close(code, shortened)
