"""A reader of recorded signals in a thread of its own, for callers without an event loop."""

import asyncio
import threading
from collections.abc import Coroutine, Sequence
from typing import Any, Final, TypeVar

from fieldrig.control.endpoint import connect
from fieldrig.control.messages import Control
from fieldrig.recording.reader import OnRows, Reader
from fieldrig.recording.signals import Column, Rhythm

T = TypeVar("T")

BEGIN_S: Final = 30.0
"""Longest time in which the recording of a running rig begins or ends."""


class LiveReader:
    """A recording of a running rig until `end`."""

    def __init__(self, endpoint: str, rig: str, signals: Sequence[str], rhythm: Rhythm, on_rows: OnRows) -> None:
        """Hand the rows to `on_rows`, which is called in the thread of the reader.

        ControlError for a signal that does not exist, or a rig that does not answer.
        """
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, name="recording", daemon=True)
        self._thread.start()
        self.complete_ns = 0
        """The instant up to which everything has been handed over."""
        self._is_ended = False
        try:
            self._control, self._reader = self._do(self._begin(endpoint, rig, signals, rhythm, on_rows))
        except BaseException:
            self._stop()
            raise

    @property
    def columns(self) -> list[Column]:
        """The recorded signals, in the order in which they were given."""
        return self._reader.columns

    @property
    def begin_ns(self) -> int:
        """The instant at which the recording began."""
        return self._reader.begin_ns

    def end(self) -> None:
        """End the recording; everything that was sampled before has been handed over.  Ending twice does no harm."""
        if not self._is_ended:
            self._is_ended = True
            try:
                self._do(self._end())
            finally:
                self._stop()

    async def _begin(
        self, endpoint: str, rig: str, signals: Sequence[str], rhythm: Rhythm, on_rows: OnRows
    ) -> tuple[Control, Reader]:
        control = Control(connect(endpoint), rig)
        reader = Reader(control, signals, rhythm, on_rows, self._on_complete)
        try:
            await reader.begin()
        except BaseException:
            await control.close()
            raise
        return control, reader

    def _on_complete(self, until_ns: int) -> None:
        self.complete_ns = until_ns

    async def _end(self) -> None:
        await self._reader.end()
        await self._control.close()

    def _do(self, work: Coroutine[Any, Any, T]) -> T:
        return asyncio.run_coroutine_threadsafe(work, self._loop).result(BEGIN_S)

    def _stop(self) -> None:
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(BEGIN_S)
        self._loop.close()
