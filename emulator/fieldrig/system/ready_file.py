"""The file `ready/NAME` in the run folder: it is there, and at most a few seconds old, while NAME is ready.

It is for health checks, which must cost next to nothing: a `fieldrig status` in each of many containers takes more of a
busy host than the rig.  NAME is a process, or `all` for the whole rig.  The file of a process that hangs or was killed
stays, but gets old:

    test "$(find run/lab/ready/all -mmin -1)"
"""

import asyncio
import logging
import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

log = logging.getLogger(__name__)

FOLDER: Final = "ready"
ALL: Final = "all"
PERIOD_S: Final = 2.0
"""Time between two looks.  A check allows for a minute, because a busy host may be late by many seconds."""


@contextmanager
def ready_file(run: Path, name: str, is_ready: Callable[[], bool]) -> Iterator[None]:
    """Keep the file while the body runs in the running loop, and remove it at the end."""
    path = run.absolute() / FOLDER / name
    keeper = asyncio.get_running_loop().create_task(_keep(path, is_ready))
    try:
        yield
    finally:
        keeper.cancel()
        with suppress(OSError):  # a file that cannot be removed gets old
            _show(path, False)


async def _keep(path: Path, is_ready: Callable[[], bool]) -> None:
    had_trouble = False
    while True:
        try:
            _show(path, is_ready())
        except OSError as cause:
            if not had_trouble:
                log.warning("%s cannot be written, so health checks will fail: %s", path, cause.strerror or cause)
            had_trouble = True
        else:
            had_trouble = False
        await asyncio.sleep(PERIOD_S)


def _show(path: Path, is_ready: bool) -> None:
    if not is_ready:
        with suppress(FileNotFoundError):
            path.unlink()
        return
    try:
        os.utime(path)
    except FileNotFoundError:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.touch()
