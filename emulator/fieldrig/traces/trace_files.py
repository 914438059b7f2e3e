"""Traces in files; the format follows from the ending of the name.

Our own format is `trace_jsonl`.  Others are modules of the same shape (SUFFIX, FAMILIES, write, read) under the entry
points "fieldrig.trace_formats".
"""

import logging
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any, BinaryIO, Final, Protocol, cast

from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.storage.record_file import RecordFile
from fieldrig.text.nearest import closest, nearest_file
from fieldrig.traces import trace_jsonl
from fieldrig.traces.trace import TraceEntry, is_batch

log = logging.getLogger(__name__)

FLUSH_S: Final = 0.5
CHUNK: Final = 8_192
"""Bytes that are written at once, at least, while messages come without a pause."""
REMEDY: Final = "name a file in a folder that is there, on a disk that has room"


class Format(Protocol):
    SUFFIX: str
    FAMILIES: frozenset[str]
    """The families of buses whose messages it can hold; empty if it can hold all."""

    def write(self, entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int) -> int: ...

    def read(self, file: BinaryIO) -> Iterator[TraceEntry]: ...


def format_of(path: Path) -> Format:
    """Return the format.  UsageError, with the known endings, for an unknown one."""
    try:
        return _formats()[path.suffix.lower()]
    except KeyError:
        known = ", ".join(f"{suffix} ({name})" for suffix, name in _names().items())
        near = closest(path.suffix.lower(), list(_names()))
        remedy = near if near.startswith("did you mean") else f"there are: {known}"
        raise UsageError(f"{path}: no format of traces ends in {path.suffix!r}", remedy) from None


def read(path: Path) -> Iterator[TraceEntry]:
    """Yield the entries of a file.  UsageError if it cannot be read, or is not a trace."""
    try:
        with path.open("rb") as file:
            yield from format_of(path).read(file)
    except OSError as cause:
        raise UsageError(f"{path} cannot be read: {cause.strerror}", nearest_file(path)) from cause


def write(entries: Iterable[TraceEntry], path: Path) -> int:
    """Write entries, which have the time of day, and return how many; a format may not know every family.

    If the entries or the disk fail, the target stays as it was.
    """
    form = format_of(path)
    try:
        with _whole(path) as file:
            return form.write(entries, file, 0)
    except OSError as cause:
        raise UsageError(f"{path} cannot be written: {cause.strerror}", REMEDY) from cause


@contextmanager
def _whole(path: Path) -> Iterator[BinaryIO]:
    """Yield a file that takes the place of `path` at the end, and is removed by an exception."""
    if path.exists() and not path.is_file():  # a pipe or a device has no other in its place
        with path.open("wb") as file:
            yield file
        return
    target = path.resolve()
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        with part.open("xb") as file:
            yield file
        part.replace(target)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


class Recorder:
    """Writes batches of `BusStream` into a file as they arrive, in a thread of its own, as formats know no loop.

    While the disk accepts nothing, the file ends at a whole message, and new ones are counted as missing; writing
    continues when there is room.
    """

    def __init__(self, path: Path, most: int | None = None) -> None:
        """Write at most `most` messages.  UsageError if the file cannot be written."""
        self._path, self._form, self._most = path, format_of(path), most
        try:
            self._file = RecordFile(path)
        except OSError as cause:
            raise UsageError(f"{path} cannot be written: {cause.strerror}", REMEDY) from cause
        self._batches: SimpleQueue[tuple[str, dict[str, Any]] | None] = SimpleQueue()
        self._expected: dict[tuple[str, str], int] = {}
        self.taken = 0
        self._lost = self._written = 0
        self._waiting = self._missing = 0  # written, but not yet on the disk; never written
        self._on_disk = 0
        self._trouble, self._next_try_s = "", 0.0
        self._thread = Thread(target=self._write, name="trace", daemon=True)
        self._thread.start()

    def take(self, bus: str, batch: Any) -> None:
        """Take a batch; any other published message is left out."""
        if not is_batch(batch) or not all(map(_is_hex, (data for _, _, data in batch["entries"]))):
            log.debug("%s: a published message is not a batch", bus)
            return
        source, size = (bus, batch["process"]), len(batch["entries"])
        # A process that was restarted counts from 0 again.
        self._lost += max(batch["first"] - self._expected.get(source, batch["first"]), 0)
        self._expected[source] = batch["first"] + size
        entries = batch["entries"] if self._most is None else batch["entries"][: self._most - self.taken]
        self.taken += len(entries)
        self._batches.put((bus, {**batch, "entries": entries}))

    @property
    def is_full(self) -> bool:
        return self._most is not None and self.taken >= self._most

    @property
    def is_whole(self) -> bool:
        """True if something was written, and the disk has refused nothing.  It is known after `close`."""
        return self._written > 0 and not self._missing

    def close(self) -> str:
        """End the file, and return a summary in words."""
        self._batches.put(None)
        self._thread.join()
        if not self._put_out(at_once=True):
            self._missing += self._waiting
            self._written -= self._waiting
        self._file.close()
        left_out = self.taken - self._missing - self._written
        words = f"{self._path}: {counted(self._written, 'message')}"
        words += f"; {self._missing} are missing: {self._trouble}" if self._missing else ""
        words += f"; {left_out} are of kinds that this format cannot hold" if left_out else ""
        return words + (f"; {self._lost} were lost: this host is too slow" if self._lost else "")

    def _write(self) -> None:
        self._written = self._form.write(self._entries(), cast(BinaryIO, self._file), 0)
        self._waiting = self._written - self._on_disk  # a format may write everything at the end

    def _entries(self) -> Iterator[TraceEntry]:
        while True:
            try:
                next_batch = self._batches.get(timeout=FLUSH_S)
            except Empty:
                self._put_out()
                continue
            if next_batch is None:
                return
            bus, batch = next_batch
            if self._file.trouble or self._file.waiting >= CHUNK:
                self._put_out()
            if self._file.trouble:
                self._missing += len(batch["entries"])
                continue
            family, epoch_ns = batch["family"], batch["epoch_ns"]
            for time_ns, sender, data in batch["entries"]:
                before = self._file.waiting
                yield TraceEntry(time_ns + epoch_ns, bus, family, sender, bytes.fromhex(data))
                self._waiting += self._file.waiting > before  # a format may leave it out

    def _put_out(self, at_once: bool = False) -> bool:
        """Write between two messages.  A disk that refused is not tried again for a while, unless `at_once`."""
        had_trouble, now_s = self._file.trouble, time.monotonic()
        if had_trouble and now_s < self._next_try_s and not at_once:
            return False
        self._next_try_s = now_s + FLUSH_S
        if not self._file.put_out():
            self._trouble = self._file.trouble
            if not had_trouble:
                log.warning("%s: %s; messages are missing from here on", self._path, self._trouble)
            return False
        self._on_disk += self._waiting
        self._waiting = 0
        if had_trouble:
            log.warning("%s: writing continues; %d messages are missing", self._path, self._missing)
        return True


def _is_hex(text: str) -> bool:
    try:
        bytes.fromhex(text)
    except ValueError:
        return False
    return True


@cache
def _formats() -> dict[str, Format]:
    loaded = [trace_jsonl, *(point.load() for point in entry_points(group="fieldrig.trace_formats"))]
    return {form.SUFFIX: cast(Format, form) for form in loaded}


def _names() -> dict[str, str]:
    points = {point.load().SUFFIX: point.name for point in entry_points(group="fieldrig.trace_formats")}
    return {trace_jsonl.SUFFIX: "JSON lines", **points}
