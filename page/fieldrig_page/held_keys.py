"""Keys that are held: each is released when the last page that holds it lets go, or has gone.

A key never sticks.  The operations of one key follow one another, so a press that is still on its way when its page
goes is followed by the release.  What is held is also in a file of the run folder, from which a page's process that was
killed learns when it starts again what to release.
"""

import asyncio
import json
import logging
from collections.abc import Awaitable, Callable
from pathlib import Path
from typing import Any, Final, NamedTuple

from fieldrig.control.messages import NoAnswerError
from fieldrig.device import Value
from fieldrig.errors import ControlError
from fieldrig.outside.untrusted import MalformedError, read_json

log = logging.getLogger(__name__)

AGAIN_S: Final = 0.5
"""Pause before a release that got no answer is sent again."""
LONGEST: Final = 1 << 16
"""Longest file of held keys, in bytes."""

Write = Callable[[str, str, Value], Awaitable[Any]]
"""Writes a point of a device.  ControlError if the device refuses, NoAnswerError if it does not answer."""


class HeldKey(NamedTuple):
    """A key, by its point, and what is written when it goes up."""

    device: str
    point: str
    released: Value


class HeldKeys:
    def __init__(self, write: Write, file: Path, again_s: float = AGAIN_S) -> None:
        self._write, self._file, self._again_s = write, file, again_s
        self._holders: dict[HeldKey, set[str]] = {}
        """The pages that hold a key."""
        self._locks: dict[HeldKey, asyncio.Lock] = {}
        self._releasing: set[asyncio.Task[None]] = set()

    @property
    def held(self) -> set[HeldKey]:
        return set(self._holders)

    async def press(self, key: HeldKey, page: str, pressed: Value) -> None:
        """Press a key for a page.  ControlError if the device refuses; then no page holds it."""
        self._holders.setdefault(key, set()).add(page)
        self._keep()
        async with self._lock(key):
            try:
                await self._write(key.device, key.point, pressed)
            except ControlError:
                self._let_go(key, page)
                raise

    async def release(self, key: HeldKey, page: str) -> None:
        """Release a key for a page; it goes up if no other page holds it."""
        self._let_go(key, page)
        async with self._lock(key):
            if key not in self._holders:
                await self._write(key.device, key.point, key.released)

    async def settled(self) -> None:
        """Wait until what pages that have gone held is released."""
        while self._releasing:
            await asyncio.wait(self._releasing)

    def drop(self, page: str) -> None:
        """Release every key of a page that has gone."""
        for key in [key for key, holders in self._holders.items() if page in holders]:
            self._begin(self._release_patiently(key, page))

    async def release_left(self) -> None:
        """Release what a former process of the page has left held."""
        for key in self._left():
            await self._release_patiently(key, "")

    async def _release_patiently(self, key: HeldKey, page: str) -> None:
        while True:
            try:
                return await self.release(key, page)
            except NoAnswerError:
                await asyncio.sleep(self._again_s)
            except ControlError as cause:  # such as a device without power, whose keys are up when it starts again
                return log.info("%s of %s: %s", key.point, key.device, cause.what)

    def _begin(self, work: Any) -> None:
        task = asyncio.get_running_loop().create_task(work)
        self._releasing.add(task)
        task.add_done_callback(self._releasing.discard)

    def _let_go(self, key: HeldKey, page: str) -> None:
        holders = self._holders.get(key, set())
        holders.discard(page)
        if not holders:
            self._holders.pop(key, None)
        self._keep()

    def _lock(self, key: HeldKey) -> asyncio.Lock:
        return self._locks.setdefault(key, asyncio.Lock())

    def _keep(self) -> None:
        try:
            self._file.parent.mkdir(parents=True, exist_ok=True)  # a rig in virtual time may have no run folder yet
            self._file.write_text(json.dumps(list(self._holders)), encoding="utf-8")
        except OSError as cause:  # a full disk takes only the release after a kill
            log.info("what is held cannot be kept: %s", cause.strerror)

    def _left(self) -> list[HeldKey]:
        try:
            rows = read_json(self._file.read_bytes(), LONGEST)
        except (OSError, MalformedError):
            return []
        if not isinstance(rows, list):
            return []
        return [HeldKey(*row) for row in rows if _is_key(row)]


def _is_key(row: Any) -> bool:
    match row:
        case [str(), str(), bool() | int() | float() | str()]:
            return True
    return False
