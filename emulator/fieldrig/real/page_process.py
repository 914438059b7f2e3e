"""The page of a rig, in a process of its own beside the rig's: started with it, restarted when it dies, ended with it.

The page is a package of its own, which the kernel finds by an entry point of the group "fieldrig.page".  The kernel
takes the page's seat, so address and tokens outlive the process.  Whatever happens to the page, the rig goes on.
"""

import asyncio
import os
import signal
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from importlib.metadata import EntryPoint
from pathlib import Path
from typing import Any, Final

from fieldrig.config import kinds
from fieldrig.config.rig_file import RigConfig
from fieldrig.control.events import event
from fieldrig.outside.page_seat import SEAT_VARIABLE, PageRole, Seat, take_seat
from fieldrig.real.child import CAN_FORK, FIRST_KEPT, Child, not_started, why_it_ended
from fieldrig.real.host import end_with_parent, name_process, start_log
from fieldrig.real.patience import Patience
from fieldrig.real.roster import Report
from fieldrig.system.exits import KILL, Exit

NICENESS: Final = 5
"""A picture may be late, a cycle of a ring may not."""
PAGES: Final = "fieldrig.page"
NAME: Final = "ui"
GRACE_S: Final = 3.0
"""Time between SIGTERM and SIGKILL."""


class PageProcess:
    """The page's process, from before the rig starts to its end."""

    def __init__(
        self, config: RigConfig, seat: Seat, page: EntryPoint, log: Path | None, overrides: Sequence[str]
    ) -> None:
        """`log` is its log; without one it writes to our output.  `overrides` are those of the rig file."""
        self._config, self._seat, self._page = config, seat, page
        self._pipe, self._own_end = os.pipe()
        line = [str(config.path)]
        for override in overrides:
            line += ["--set", override]
        self._child = Child(
            [*line, "--seat"],
            log,
            self._pipe,
            module=page.value,
            kept=seat.listener.fileno(),
            environment={SEAT_VARIABLE: seat.to_text()},
        )
        self._patience = Patience(config.start_timeout_s)
        self._restarts = 0

    @property
    def addresses(self) -> dict[PageRole, str]:
        """The address of the page for each role, with its token."""
        return self._seat.addresses()

    def fork(self) -> None:
        """Fork the process where the system can.  Call it before the first thread and before there is a loop.

        RigError if the system has no descriptor, process or memory for it.
        """
        if CAN_FORK:
            try:
                self._child.fork(partial(_work, self._page, self._config, self._seat))
            except OSError as cause:
                raise not_started(cause, "of the page", "or leave the page out: fieldrig up --no-ui") from cause

    def status(self) -> dict[str, Any]:
        """Return its part of `fieldrig status`."""
        pid = self._child.pid
        place = next(iter(self.addresses.values())).partition("?")[0]  # without a token, which belongs to the user
        state = "running" if pid is not None else "dead"
        return {NAME: {"state": state, "pid": pid, "restarts": self._restarts, "address": place}}

    async def tend(self, report: Report) -> None:
        """Start the process again whenever it has ended, until cancelled."""
        loop = asyncio.get_running_loop()
        while True:
            if self._child.pid is not None:
                begun_s = loop.time()
                code = await self._child.wait()
                self._child.forget_steps()
                why = why_it_ended(code, self._child.tail())
                report(event("died", NAME, f"{why}; the rig goes on, and the page is started again"))
                await asyncio.sleep(self._patience.after_death(loop.time() - begun_s))
                self._restarts += 1
            try:
                await self._child.spawn()
            except OSError as cause:
                report(event("late", NAME, f"the page cannot be started: {cause.strerror or cause}; trying again"))
                await asyncio.sleep(self._patience.after_death(0.0))

    async def end(self) -> None:
        """End the process in order, and kill it after `GRACE_S`."""
        self._child.end(signal.SIGTERM)
        if self._child.pid is not None:
            ending = asyncio.get_running_loop().create_task(self._child.wait())
            if not (await asyncio.wait({ending}, timeout=GRACE_S))[0]:
                self._child.end(KILL)
            await ending

    def close(self) -> None:
        """Kill the process if it still runs, and release its address."""
        os.close(self._own_end)
        self._child.forget_steps()
        self._child.kill()
        os.close(self._pipe)
        self._seat.close()


@contextmanager
def page_of(config: RigConfig, log: Path | None, overrides: Sequence[str]) -> Iterator[PageProcess | None]:
    """Run the page of a rig; None if the rig file wants none, no package has a page, or the system is not POSIX.

    RigError if the page cannot have its address.
    """
    page = next(iter(kinds.installed(PAGES).values()), None)
    if config.ui is None or page is None or os.name != "posix":
        yield None
        return
    process = PageProcess(config, take_seat(config.ui.listen, config.ui.hosts), page, log, overrides)
    try:
        process.fork()
        yield process
    finally:
        process.close()


def _work(page: EntryPoint, config: RigConfig, seat: Seat) -> Exit:
    """Serve the page in the forked process, which has nothing of its parent but memory and the inherited socket."""
    start_log()
    prepare()
    run: Callable[[RigConfig, Seat], Exit] = page.load().run
    return run(config, Seat.from_text(seat.to_text(), FIRST_KEPT))


def prepare() -> None:
    """Prepare a process of the page: it has its name, gives way to the rig, and ends when its parent is gone."""
    name_process(NAME)
    if hasattr(os, "nice"):
        os.nice(NICENESS)
    end_with_parent(lambda: os.kill(os.getpid(), signal.SIGTERM))
