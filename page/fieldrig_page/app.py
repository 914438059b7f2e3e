"""The page of a rig as a web application: its topics, its HTTP API, its files, and the guard before them.

Each part of the page adds a line to `TOPICS` or `OPERATIONS`.
"""

import asyncio
import base64
import hashlib
import json
import mimetypes
import re
from collections.abc import Callable, Iterable
from importlib.metadata import version
from pathlib import Path
from typing import Final

from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, Response
from starlette.routing import Mount, Route, WebSocketRoute
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from fieldrig.errors import RigError
from fieldrig.outside.page_seat import Seat
from fieldrig_page import api, metrics, picture_api, points_api, rig_api
from fieldrig_page.api import Operation
from fieldrig_page.faults import Faults
from fieldrig_page.fronts import Fronts
from fieldrig_page.guard import Guard, Hosts
from fieldrig_page.life import Life
from fieldrig_page.live import Live, Topic
from fieldrig_page.programs import Programs
from fieldrig_page.rig_link import RigLink
from fieldrig_page.rig_state import RigState
from fieldrig_page.scope.scope import Scope
from fieldrig_page.traffic import Traffic
from fieldrig_page.values import Values
from fieldrig_page.wires import Wires

STATIC: Final = Path(__file__).parent / "static"

TOPICS: Final[tuple[Callable[[RigLink], Topic], ...]] = (
    RigState,
    Life,
    Wires,
    Fronts,
    Values,
    Traffic,
    Faults,
    Programs,
    Scope,
)
OPERATIONS: Final[tuple[Callable[[RigLink], Iterable[Operation]], ...]] = (
    rig_api.operations,
    picture_api.operations,
    points_api.operations,
)

# Whatever the system says that these are: a browser runs no module of another type.
for ending in (".js", ".mjs"):
    mimetypes.add_type("text/javascript", ending)


class Site:
    """Everything that one process of the page serves."""

    def __init__(self, link: RigLink, seat: Seat) -> None:
        self.link = link
        self.topics = [make(link) for make in TOPICS]
        self.operations = [operation for group in OPERATIONS for operation in group(link)]
        for topic in self.topics:
            if isinstance(topic, api.HasOperations):
                self.operations += topic.operations()
        greeting = {"rig": link.config.name, "time": link.config.time, "version": version("fieldrig"), "build": build()}
        self.live = Live(self.topics, greeting)
        self.app: ASGIApp = Guard(
            self._application(), Hosts(seat.address, seat.hosts), seat.address[1], seat.tokens, hashes()
        )

    async def run(self) -> None:
        """Do the work of all topics and sockets until cancelled.  A fault in one of them ends it."""
        async with asyncio.TaskGroup() as tasks:
            tasks.create_task(self.live.run())
            for topic in self.topics:
                tasks.create_task(topic.run())

    def _application(self) -> Starlette:
        description = json.dumps(api.document(self.operations, self.link.config.name)).encode()

        async def openapi(_request: Request) -> Response:
            return Response(description, media_type="application/json")

        async def index(_request: Request) -> Response:
            return FileResponse(STATIC / "index.html")

        application = Starlette(
            routes=[
                Route("/", index),
                WebSocketRoute("/live", self.live.serve),
                Route(f"{api.BASE}/openapi.json", openapi),
                *metrics.routes(self.link, self.live),
                *(operation.route() for operation in self.operations),
                Mount("/static", StaticFiles(directory=STATIC)),
            ],
            exception_handlers={HTTPException: _not_there},
        )
        application.router.redirect_slashes = False  # a path with a slash too many is not there, as any other
        return application


def hashes() -> list[str]:
    """Return the hashes of the scripts inside of the page: the import map, which has to be inside."""
    page = (STATIC / "index.html").read_text(encoding="utf-8")
    scripts = re.findall(r"<script[^>]*>(.+?)</script>", page, re.DOTALL)
    return [f"sha256-{base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()}" for script in scripts]


def build() -> str:
    """Return what differs whenever the files of the page do, so that an open page is loaded again."""
    digest = hashlib.sha256()
    for file in sorted(path for path in STATIC.rglob("*") if path.is_file()):
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


async def _not_there(request: Request, cause: Exception) -> Response:
    """Answer a path or a method that is not there, in the form of its neighbours."""
    assert isinstance(cause, HTTPException)
    if request.url.path.startswith("/api/"):
        what = f"there is no {request.method} {request.url.path}"
        return api.refused(RigError(what, f"see {api.BASE}/openapi.json"), cause.status_code)
    return Response(f"{cause.detail}\n", cause.status_code, media_type="text/plain")
