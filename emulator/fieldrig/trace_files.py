"""Traces in files: the format goes by the ending of the name.

Our own is `trace_jsonl`.  Others are modules of the same shape (SUFFIX, write, read) under the entry points
"fieldrig.trace_formats".
"""

import logging
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.metadata import entry_points
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any, BinaryIO, Final, Protocol, cast

from fieldrig import trace_jsonl
from fieldrig.errors import UsageError
from fieldrig.trace import TraceEntry, is_batch

log = logging.getLogger(__name__)

FLUSH_S: Final = 0.5


class Format(Protocol):
    SUFFIX: str

    def write(self, entries: Iterable[TraceEntry], file: BinaryIO, start_unix_ns: int) -> int: ...

    def read(self, file: BinaryIO) -> Iterator[TraceEntry]: ...


def format_of(path: Path) -> Format:
    """UsageError, with the endings that are known, for another one."""
    try:
        return _formats()[path.suffix.lower()]
    except KeyError:
        known = ", ".join(f"{suffix} ({name})" for suffix, name in _names().items())
        raise UsageError(f"{path}: no format of traces ends in {path.suffix!r}", f"there are: {known}") from None


def read(path: Path) -> Iterator[TraceEntry]:
    """UsageError for a file that can't be read, or is something else."""
    form = format_of(path)
    try:
        with path.open("rb") as file:
            yield from form.read(file)
    except OSError as cause:
        raise UsageError(f"{path} can't be read: {cause.strerror}") from cause


def write(entries: Iterable[TraceEntry], path: Path) -> int:
    """How many were written: a format may not know every family.  Entries have the time of day."""
    form = format_of(path)
    try:
        with path.open("wb") as file:
            return form.write(entries, file, 0)
    except OSError as cause:
        raise UsageError(
            f"{path} can't be written: {cause.strerror}", "name a file in a folder that is there"
        ) from cause


class Recorder:
    """Writes batches of `BusStream` into a file as they come, in a thread of its own: formats know no loop."""

    def __init__(self, path: Path, most: int | None = None) -> None:
        """At most so many messages.  UsageError if the file can't be written."""
        self._path, self._form, self._most = path, format_of(path), most
        try:
            self._file = path.open("wb")
        except OSError as cause:
            remedy = "name a file in a folder that is there"
            raise UsageError(f"{path} can't be written: {cause.strerror}", remedy) from cause
        self._batches: SimpleQueue[tuple[str, dict[str, Any]] | None] = SimpleQueue()
        self._expected: dict[tuple[str, str], int] = {}
        self.taken = 0
        self._lost = self._written = 0
        self._thread = Thread(target=self._write, name="trace", daemon=True)
        self._thread.start()

    def take(self, bus: str, batch: Any) -> None:
        """A batch; anything else that somebody told is left out."""
        if not is_batch(batch) or not all(map(_is_hex, (data for _, _, data in batch["entries"]))):
            log.debug("%s: told something that is no batch", bus)
            return
        source, size = (bus, batch["process"]), len(batch["entries"])
        self._lost += batch["first"] - self._expected.get(source, batch["first"])
        self._expected[source] = batch["first"] + size
        entries = batch["entries"] if self._most is None else batch["entries"][: self._most - self.taken]
        self.taken += len(entries)
        self._batches.put((bus, {**batch, "entries": entries}))

    @property
    def is_full(self) -> bool:
        return self._most is not None and self.taken >= self._most

    def close(self) -> str:
        """What became of it, in words."""
        self._batches.put(None)
        self._thread.join()
        self._file.close()
        left_out = self.taken - self._written
        words = f"{self._path}: {self._written} messages"
        words += f"; {left_out} are of kinds that this format doesn't know" if left_out else ""
        return words + (f"; {self._lost} were lost: this computer is too slow" if self._lost else "")

    def _write(self) -> None:
        self._written = self._form.write(self._entries(), self._file, 0)

    def _entries(self) -> Iterator[TraceEntry]:
        while True:
            try:
                told = self._batches.get(timeout=FLUSH_S)
            except Empty:
                self._file.flush()
                continue
            if told is None:
                return
            bus, batch = told
            family, epoch_ns = batch["family"], batch["epoch_ns"]
            for time_ns, sender, data in batch["entries"]:
                yield TraceEntry(time_ns + epoch_ns, bus, family, sender, bytes.fromhex(data))


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
