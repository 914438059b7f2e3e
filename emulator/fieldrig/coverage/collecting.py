"""A switch for marks in the programs that are compiled, and a folder in which all processes note what they have run.

It is one for a whole process and those that it starts, as the compilers and run times of all devices of a rig have to
see it, and a rig's file says nothing of it.  Each program has a file with its places, and each process that runs it one
with its marks beside it, which `flush` writes.  So a process that is killed loses only what it has run since then.
"""

import json
import logging
import os
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from fieldrig.coverage.folder import DETAIL_VARIABLE, FOLDER_VARIABLE
from fieldrig.coverage.places import Marked, News, Place

log = logging.getLogger(__name__)

FLUSH_S: Final = 0.5
"""The longest time for which a process of a rig keeps what it has run to itself, in seconds."""
_PLACES: Final = ".places"


class _Noted:
    """One program with the file of its places."""

    def __init__(self, marked: Marked, file: Path) -> None:
        self.marked, self.hits, self._file = marked, [0] * len(marked.hits), file
        self._written = bytes(len(self.hits))
        file.with_suffix(".new").write_text(json.dumps(marked.places), encoding="utf-8")
        file.with_suffix(".new").replace(file)

    def flush(self) -> None:
        """Write the marks of this process if they have changed.

        A process that was forked begins with those of its parent, and has a file of its own; another process may have
        had its number before.
        """
        hits = self.hits
        if bytes(hits) == self._written:
            return
        file = self._file.with_suffix(f".{os.getpid()}.hits")
        with suppress(OSError):
            for mark, is_hit in enumerate(file.read_bytes()):
                hits[mark] |= is_hit
        self._written = bytes(hits)
        file.write_bytes(self._written)


class Collector:
    """The notes of this process and those that it starts about the programs that they compile meanwhile."""

    def __init__(self, folder: Path, *, is_detailed: bool = False, is_written: bool = True) -> None:
        self._folder, self.is_detailed, self._is_written = folder, is_detailed, is_written
        self._known: list[_Noted] = []
        self.flushed_s = 0.0
        """The instant of the last flush, by the clock of the host."""

    def use(self, marked: Marked) -> None:
        """Give a program that is loaded its marks here: new ones, or those of an earlier time that it was loaded."""
        known = next((one for one in self._known if one.marked is marked), None)
        if known is None and marked.hits:
            try:
                known = _Noted(marked, self._new_file())
            except OSError as cause:  # a full disk, or a folder that is gone, is no fault of the program
                log.warning("the coverage of a program is not noted: %s", cause)
                return
            self._known.append(known)
        if known is not None:
            marked.hits = known.hits

    def _new_file(self) -> Path:
        number = len(self._known)
        while (file := self._folder / f"{os.getpid()}-{number}{_PLACES}").exists():
            number += 1
        return file

    @property
    def programs(self) -> Sequence[Marked]:
        """The programs that this process has loaded, in their order, each with its present marks."""
        return [known.marked for known in self._known]

    def flush(self) -> None:
        """Write what this process has run so far."""
        if not self._is_written:
            return
        self.flushed_s = time.monotonic()
        for known in self._known:
            with suppress(OSError):  # as above
                known.flush()

    def news(self) -> News:
        """Return the places of all programs so far, and whether they have run."""
        self.flush()
        return tuple(_noted_in(self._folder))


def _noted_in(folder: Path) -> Iterator[tuple[Place, bool]]:
    for file in sorted(folder.glob(f"*{_PLACES}")):
        places = [(mark, Place.read(fields)) for mark, fields in json.loads(file.read_text(encoding="utf-8"))]
        hits = [one.read_bytes() for one in folder.glob(f"{file.stem}.*.hits")]
        reached = {mark for one in hits for mark, is_hit in enumerate(one) if is_hit}
        yield from ((place, mark in reached) for mark, place in places)


_present: list[Collector] = []
if FOLDER_VARIABLE in os.environ:
    _present.append(Collector(Path(os.environ[FOLDER_VARIABLE]), is_detailed=DETAIL_VARIABLE in os.environ))


@contextmanager
def collecting(*, is_detailed: bool = False, is_written: bool = True) -> Iterator[Collector]:
    """Compile programs with marks meanwhile, here and in processes that are started, and note what runs of them.

    With `is_detailed`, conditions and the states of enumerations have marks too.  Without `is_written` the caller takes
    the marks of each process from its memory: a search with thousands of branches would write as many files.
    """
    before = {name: os.environ.pop(name, None) for name in (FOLDER_VARIABLE, DETAIL_VARIABLE)}
    with TemporaryDirectory(prefix="fieldrig-coverage-") as folder:
        os.environ[FOLDER_VARIABLE] = folder
        if is_detailed:
            os.environ[DETAIL_VARIABLE] = "1"
        _present.append(Collector(Path(folder), is_detailed=is_detailed, is_written=is_written))
        try:
            yield _present[-1]
        finally:
            _present.pop().flush()
            for name, value in before.items():
                os.environ.pop(name, None)
                if value is not None:
                    os.environ[name] = value
            if outer := before[FOLDER_VARIABLE]:
                _hand_over(Path(folder), Path(outer))


def _hand_over(inner: Path, outer: Path) -> None:
    """Move the notes of a block into those of the one around it, under names that are new there."""
    for file in inner.iterdir():
        with suppress(OSError):
            file.replace(outer / f"{inner.name}-{file.name}")


def is_on() -> bool:
    return bool(_present)


def is_detailed() -> bool:
    """True if conditions and the states of enumerations count as well."""
    return bool(_present) and _present[-1].is_detailed


def use(marked: Marked) -> None:
    """Take note of a program that is loaded, before its code is bound to its marks: they are new ones."""
    if _present:
        _present[-1].use(marked)


def programs() -> Sequence[Marked]:
    """Return the programs that this process has loaded, in their order, each with its present marks."""
    return _present[-1].programs if _present else ()


def news() -> News:
    """Return the places of all programs so far, and whether they have run."""
    return _present[-1].news() if _present else ()


def flush_now_and_then() -> None:
    """Note it if it is `FLUSH_S` since the last time; a process without a clock of its own calls it after each step."""
    if _present and time.monotonic() >= _present[-1].flushed_s + FLUSH_S:
        _present[-1].flush()


def flush() -> None:
    """Note what this process has run so far; it has to do so before it ends."""
    if _present:
        _present[-1].flush()
