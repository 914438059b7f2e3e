"""A recording of a running rig in a file."""

import io
import logging
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any, BinaryIO, Final, cast

from fieldrig.errors import UsageError
from fieldrig.points.values import counted
from fieldrig.storage.record_file import RecordFile
from fieldrig.traces import trace_jsonl
from fieldrig.traces.formats import Format, WritesBack, format_of
from fieldrig.traces.trace import TraceEntry, is_batch
from fieldrig.traces.trace_files import REMEDY, read, write

log = logging.getLogger(__name__)

FLUSH_S: Final = 0.5
CHUNK: Final = 8_192
"""Bytes that are written at once, at least, while messages come without a pause."""


class Recorder:
    """Writes batches of `BusStream` into a file as they arrive, in a thread of its own, as formats know no loop.

    While the disk accepts nothing, the file ends at a whole message, and new ones are counted as missing; writing
    continues when there is room.  A format that changes what it has written gets its messages at the end; until then
    they are in JSON lines beside the file.

    When a rig in virtual time goes back, what came after that instant is removed: the file is written again.
    """

    def __init__(self, path: Path, most: int | None = None) -> None:
        """Write at most `most` messages.  UsageError if the file cannot be written."""
        self._target, self._most = path, most
        self._path, self._form = path, format_of(path)
        if isinstance(self._form, WritesBack):
            self._form.write((), io.BytesIO(), 0)  # a library that is missing is named now, and not at the end
            self._path, self._form = path.with_name(f"{path.name}.jsonl"), cast(Format, trace_jsonl)
        try:
            self._file = RecordFile(self._path)
        except OSError as cause:
            raise UsageError(f"{path} cannot be written: {cause.strerror}", REMEDY) from cause
        self._batches: SimpleQueue[tuple[str, dict[str, Any]] | None] = SimpleQueue()
        self._expected: dict[tuple[str, str], int] = {}
        self.taken = 0
        self._lost = self._written = 0
        self._waiting = self._missing = 0  # written, but not yet on the disk; never written
        self._on_disk = 0
        self._gone = 0
        """Messages that were written and are gone, because the rig went back."""
        self._backs = 0
        """How often the rig had gone back at the last batch."""
        self._later: dict[str, Any] | None = None
        """The batch after which the file goes on, while it is written again."""
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
        if self._path != self._target:
            self._convert()
        left_out = self.taken - self._missing - self._written - self._gone
        words = f"{self._target}: {counted(self._written, 'message')}"
        words += f"; {self._missing} are missing: {self._trouble}" if self._missing else ""
        words += f"; {left_out} are of kinds that this format cannot hold" if left_out else ""
        return words + (f"; {self._lost} were lost: this host is too slow" if self._lost else "")

    def _convert(self) -> None:
        """Write the target from the messages beside it, which stay if that fails.  UsageError then."""
        try:
            self._written = write(read(self._path), self._target)
        except UsageError as wrong:
            raise UsageError(wrong.what, f"the messages are in {self._path}; convert them when it can be") from wrong
        with suppress(OSError):
            self._path.unlink()

    def _write(self) -> None:
        kept: Iterator[TraceEntry] = iter(())
        before = self._before
        while True:
            self._written = self._form.write(self._entries(kept), cast(BinaryIO, self._file), 0)
            self._waiting = self._written - self._on_disk  # a format may write everything at the end
            if self._later is None:
                break
            kept = self._cut(self._later["back_ns"], before)
        with suppress(OSError):
            before.unlink()

    def _cut(self, back_ns: int, before: Path) -> Iterator[TraceEntry]:
        """Begin the file again, and return the messages that stay, up to the instant that the rig went back to."""
        self._put_out(at_once=True)
        self._file.close()
        self._file = RecordFile(self._path)
        self._gone += self._written
        self._on_disk = self._waiting = 0
        return (entry for entry in read(before) if entry.time_ns <= back_ns)

    def _is_to_cut(self, batch: dict[str, Any]) -> bool:
        """Put the file aside if the rig has gone back before this batch, and return whether it was possible.

        A pipe or a device keeps what it was given.
        """
        backs, self._backs = self._backs, max(self._backs, batch.get("backs", 0))
        if self._backs == backs or not self._path.is_file() or self._file.trouble:
            return False
        try:
            self._path.replace(self._before)
        except OSError as cause:
            log.warning("%s keeps what the rig has gone back over: %s", self._path, cause.strerror)
            return False
        return True

    @property
    def _before(self) -> Path:
        """The file aside, while it is written again."""
        return self._path.with_name(f".before.{self._path.name}")

    def _entries(self, kept: Iterator[TraceEntry]) -> Iterator[TraceEntry]:
        """Yield what stays of a file that is written again, then what comes, until it ends or the rig goes back."""
        for entry in kept:
            self._gone -= 1
            if self._file.waiting >= CHUNK:
                self._put_out()
            yield from self._counted(entry)
        batch, self._later = self._later, None
        if batch is not None:
            yield from self._messages(batch)
        while True:
            try:
                next_batch = self._batches.get(timeout=FLUSH_S)
            except Empty:
                self._put_out()
                continue
            if next_batch is None:
                return
            bus, taken = next_batch
            batch = {**taken, "bus": bus}
            if self._is_to_cut(batch):
                self._later = batch
                return
            yield from self._messages(batch)

    def _messages(self, batch: dict[str, Any]) -> Iterator[TraceEntry]:
        if self._file.trouble or self._file.waiting >= CHUNK:
            self._put_out()
        if self._file.trouble:
            self._missing += len(batch["entries"])
            return
        bus, family, epoch_ns = batch["bus"], batch["family"], batch["epoch_ns"]
        for time_ns, sender, data in batch["entries"]:
            yield from self._counted(TraceEntry(time_ns + epoch_ns, bus, family, sender, bytes.fromhex(data)))

    def _counted(self, entry: TraceEntry) -> Iterator[TraceEntry]:
        """Yield an entry, and count it if the format has written it."""
        before = self._file.waiting
        yield entry
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
