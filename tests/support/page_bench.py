"""The page of a rig in virtual time within one process: no sockets, no browser, no second process.

    async with page_of("configs/lab.yaml") as page:
        answer = await page.get("devices/tank/points/level")
        assert answer.json == {"key": "level", "value": 0.5, "unit": "m"}
        socket = await page.socket()
        await socket.send({"t": "want", "topic": "rig", "wish": True})
        frame = await socket.until("rig")

The rig is paused, and moves by `POST rig/step` or `page.ask("rig/step", {"ns": ...})`.
"""

import asyncio
import json
from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, Self, cast

import msgpack
from memory_control import MemoryControl
from starlette.types import Message

from fieldrig.config.rig_file import RigConfig, from_dict, load
from fieldrig.control.messages import Control
from fieldrig.outside.page_seat import Seat
from fieldrig.virtual.service import VirtualService
from fieldrig_page.app import Site
from fieldrig_page.live import Role
from fieldrig_page.rig_link import RigLink

HOST = "127.0.0.1:8372"
TANK: Final[dict[str, Any]] = {
    "time": "virtual",
    "buses": {"wires": {"kind": "wires.virtual"}},
    "devices": {
        "tank": {
            "kind": "plant.tank",
            "area_m2": 1,
            "height_m": 2,
            "outlet_area_m2": 0.001,
            "pump_flow_m3_per_s": 0.002,
            "links": {"wires": "wires"},
        }
    },
}
"""The smallest rig with something to see: a tank."""
TOKENS: dict[Role, str] = {"operate": "token-to-operate", "look": "token-to-look"}


class NoListener:
    """The listening socket of a page that is only called directly."""

    def getsockname(self) -> tuple[str, int]:
        return "127.0.0.1", 8372


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to one request."""

    status: int
    headers: Mapping[str, str]
    body: bytes

    @property
    def json(self) -> Any:
        return json.loads(self.body)


class PageBench:
    """A page's server, as a browser or a script meets it."""

    def __init__(self, site: Site, control: MemoryControl) -> None:
        self.site, self.control = site, control

    async def ask(self, path: str, message: Any = None) -> Any:
        """Ask the rig, past the page."""
        return await self.control.ask(path, message, 60)

    async def get(self, path: str, role: Role = "operate") -> Answer:
        """Call an operation of the API that reads."""
        return await self.request("GET", f"/api/v1/{path}", headers=bearer(role))

    async def call(self, method: str, path: str, body: Any = None, role: Role = "operate") -> Answer:
        """Call an operation of the API."""
        data = b"" if body is None else json.dumps(body).encode()
        return await self.request(method, f"/api/v1/{path}", data, bearer(role))

    async def request(
        self, method: str, path: str, body: bytes = b"", headers: Mapping[str, str] | None = None
    ) -> Answer:
        """Send any request.  `Host` is the page's own unless `headers` has another."""
        scope = _scope("http", path, {"host": HOST, **(headers or {})}) | {"method": method, "scheme": "http"}
        sent: list[Message] = []
        parts = [{"type": "http.request", "body": body, "more_body": False}]

        async def receive() -> Message:
            return parts.pop() if parts else {"type": "http.disconnect"}

        async def send(message: Message) -> None:
            sent.append(message)

        await self.site.app(scope, receive, send)
        begin, *rest = sent
        given = {name.decode(): value.decode() for name, value in begin["headers"]}
        return Answer(begin["status"], given, b"".join(message.get("body", b"") for message in rest))

    async def socket(self, role: Role | None = "operate", headers: Mapping[str, str] | None = None) -> "Socket":
        """Open a socket as the page's own script does; role None: without a cookie.  ConnectionError if refused."""
        cookie = {} if role is None else {"cookie": f"fieldrig-8372={TOKENS[role]}"}
        socket = Socket(
            _scope("websocket", "/live", {"host": HOST, "origin": f"http://{HOST}", **cookie, **(headers or {})})
        )
        return await socket.open(self.site)


class Socket:
    """One socket of a page, which acknowledges everything that it gets while `acknowledges` is true."""

    def __init__(self, scope: dict[str, Any]) -> None:
        self._scope = scope
        self._in: asyncio.Queue[Message] = asyncio.Queue()
        self._out: asyncio.Queue[Message] = asyncio.Queue()
        self._serving: asyncio.Task[None] | None = None
        self.acknowledges = True
        self.ticks: list[int] = []
        """The numbers of the ticks so far."""
        self._messages: list[dict[str, Any]] = []

    async def open(self, site: Site) -> Self:
        self._in.put_nowait({"type": "websocket.connect"})

        async def serve() -> None:
            await site.app(self._scope, self._in.get, self._out.put)

        self._serving = asyncio.get_running_loop().create_task(serve())
        first = await self._out.get()
        if first["type"] != "websocket.accept":
            raise ConnectionError(f"refused: {first}")
        return self

    async def send(self, message: Any) -> None:
        await self.send_bytes(msgpack.packb(message))

    async def send_bytes(self, data: bytes) -> None:
        self._in.put_nowait({"type": "websocket.receive", "bytes": data})

    async def send_text(self, text: str) -> None:
        self._in.put_nowait({"type": "websocket.receive", "text": text})

    async def next(self) -> dict[str, Any]:
        """Return the next message.  ConnectionError, with the code, if the server has closed the socket."""
        while not self._messages:
            got = await self._out.get()
            if got["type"] != "websocket.send":
                raise ConnectionError(got["code"])
            number, *self._messages = msgpack.unpackb(got["bytes"])
            self.ticks.append(number)
            if self.acknowledges:
                await self.send({"t": "seen", "number": number})
        return self._messages.pop(0)

    async def until(
        self, topic: str, condition: Callable[[dict[str, Any]], bool] = lambda _message: True
    ) -> dict[str, Any]:
        """Return the next message of a topic that fulfils the condition."""
        while not ((message := await self.next())["t"] == topic and condition(message)):
            pass
        return message

    async def close(self) -> None:
        """Go away, as a browser does."""
        self._in.put_nowait({"type": "websocket.disconnect", "code": 1001})
        if self._serving is not None:
            await self._serving


@asynccontextmanager
async def page_of(rig: str | Path | dict[str, Any], *overrides: str) -> AsyncIterator[PageBench]:
    """The page of a rig file, or of the data of one, that runs in virtual time and is paused at its start."""
    config: RigConfig = from_dict(rig) if isinstance(rig, dict) else load(rig, (*overrides, "time=virtual"))
    memory = MemoryControl(config.name)
    control = cast(Control, memory)
    service = VirtualService(config, control, lambda _event: None)
    running = asyncio.get_running_loop().create_task(service.run())
    while "rig/*" not in memory.served:  # it builds its devices first
        if running.done():
            running.result()
        await asyncio.sleep(0)
    await memory.ask("rig/pause", None, 60)
    site = Site(RigLink(config, control), Seat(cast(Any, NoListener()), (), dict(TOKENS)))
    working = asyncio.get_running_loop().create_task(site.run())
    try:
        yield PageBench(site, memory)
        if working.done():
            working.result()
    finally:
        working.cancel()
        service.end()
        await asyncio.wait({working, running})
    running.result()


def bearer(role: Role) -> dict[str, str]:
    return {"authorization": f"Bearer {TOKENS[role]}"}


def _scope(kind: str, path: str, headers: Mapping[str, str]) -> dict[str, Any]:
    path, _, query = path.partition("?")
    return {
        "type": kind,
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "path": path,
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "root_path": "",
        "headers": [(name.encode(), value.encode()) for name, value in headers.items()],
        "server": ("127.0.0.1", 8372),
        "client": ("127.0.0.1", 40000),
        "subprotocols": [],
    }
