"""The process of the page of a rig: an entry point of the group "fieldrig.page", which the kernel starts beside a rig.

`run` serves the page with the rig file that is loaded already; `main` loads it, for a restart, and for the page of a
rig that runs elsewhere: `python -m fieldrig_page RIGFILE --control ENDPOINT`.
"""

import argparse
import asyncio
import logging
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Final, NoReturn

import uvicorn

from fieldrig.config.rig_file import RigConfig, load
from fieldrig.control import endpoint
from fieldrig.control.messages import Control
from fieldrig.errors import RigError
from fieldrig.outside.page_seat import Seat, inherited_seat, take_seat
from fieldrig.real.host import loop_factory, start_log
from fieldrig.real.page_process import prepare
from fieldrig.real.progress import finish, step
from fieldrig.system import log_files
from fieldrig.system.exits import Exit
from fieldrig.system.this_process import facts, on_signals
from fieldrig_page.app import Site
from fieldrig_page.connections import Connection
from fieldrig_page.rig_link import RigLink
from fieldrig_page.wire import LONGEST

PATIENCE_S: Final = 3600.0
"""Longest wait for a rig that starts; its supervisor gives up first."""
GRACE_S: Final = 1
"""Time for open connections at the end."""
QUEUE: Final = 8
"""Messages of one socket that wait to be taken; further ones stay in its connection."""


class Server(uvicorn.Server):
    """The server without signal handlers of its own."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


class WithoutTraces(logging.Filter):
    """A text of a client that is not UTF-8 is no fault of the server, so its line in the log has no traceback."""

    def filter(self, record: logging.LogRecord) -> bool:
        if isinstance(record.exc_info, tuple) and isinstance(record.exc_info[1], UnicodeDecodeError):
            record.exc_info = None
        return True


def run(config: RigConfig, seat: Seat, patience_s: float = PATIENCE_S) -> Exit:
    """Serve the page until the process is asked to end."""
    try:
        with asyncio.Runner(loop_factory=loop_factory()) as runner:
            runner.run(serve(config, seat, patience_s))
    except RigError as cause:
        print(f"error: {cause}", file=sys.stderr)  # noqa: T201  for the log, or for the user
        return Exit.CANNOT_START
    except Exception:
        logging.getLogger(__name__).exception("a fault in the page's process")
        return Exit.CRASHED
    return Exit.OK


async def serve(config: RigConfig, seat: Seat, patience_s: float) -> None:
    """Connect to the rig, and serve the page until SIGTERM or SIGINT."""
    logging.getLogger("uvicorn").setLevel(logging.WARNING)  # it tells of every socket
    logging.getLogger("uvicorn.error").addFilter(WithoutTraces())
    step("connecting to the rig")
    control = Control(await endpoint.connect_patiently(config.control, patience_s), config.name)
    try:
        site = Site(RigLink(config, control), seat)
        server = Server(server_config(site))
        on_signals(("SIGTERM", "SIGINT"), lambda: setattr(server, "should_exit", True))

        async def status(_verb: str, _message: object) -> dict[str, object]:
            return {
                **facts(),
                "state": "ready",
                "pages": len(site.live.pages),
                "limits": Connection.door.reached.figures(),
            }

        control.serve("ui/status", status)
        working = asyncio.get_running_loop().create_task(site.run())
        serving = asyncio.get_running_loop().create_task(server.serve([seat.listener]))
        finish()
        try:
            await asyncio.wait({working, serving}, return_when=asyncio.FIRST_COMPLETED)
            if working.done():
                working.result()  # a fault in a topic
            serving.result()
        finally:
            working.cancel()
            await asyncio.wait({working})
    finally:
        await control.close()


def server_config(site: Site) -> uvicorn.Config:
    """Return how the site is served: without what others would see, and with limits."""
    return uvicorn.Config(
        site.app,
        http=Connection,
        ws="websockets-sansio",
        loop="none",
        lifespan="off",
        log_config=None,
        access_log=False,
        server_header=False,
        ws_max_size=LONGEST,
        ws_max_queue=QUEUE,
        ws_per_message_deflate=False,
        timeout_graceful_shutdown=GRACE_S,
    )


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    parser = argparse.ArgumentParser(prog="python -m fieldrig_page", description=__doc__)
    parser.add_argument("file", type=Path, help="the rig file of the rig that runs")
    parser.add_argument("--control", metavar="ENDPOINT", help="control endpoint of the rig, if not the rig file's")
    parser.add_argument("--seat", type=int, help="descriptor of the socket that it inherits; its supervisor has it")
    parser.add_argument("--log", type=Path, help="a file of bounded size for what it says")
    parser.add_argument("--listen", metavar="HOST:PORT", help="where the page listens, if not at its usual place")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    options = parser.parse_args(arguments)
    if options.log is not None:
        log_files.take_over(options.log)
    start_log()
    if options.seat is not None:
        prepare()
    overrides = [*options.set, *([f"control={options.control}"] if options.control is not None else [])]
    try:
        config = load(options.file, overrides)
        seat = take_seat(options.listen) if options.seat is None else inherited_seat(options.seat)
    except RigError as wrong:
        print(f"error: {wrong}", file=sys.stderr)  # noqa: T201
        sys.exit(Exit.WRONG)
    if options.seat is None:
        for role, address in seat.addresses().items():
            print(f"page to {role}: {address}", flush=True)  # noqa: T201
    sys.exit(run(config, seat, PATIENCE_S if options.seat is not None else config.start_timeout_s))
