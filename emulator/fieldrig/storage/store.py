"""A device's non-volatile memory: one blob of bytes with a checksum and its previous version, and RAM with a battery.

Nothing that was saved is lost when a process is killed: a version is written aside, flushed to the disk and renamed;
the version before it stays beside it and is the fallback.  Buffered RAM is a mapped file: what is written to it is
there for the next process at once, however this one ends.

A disk that accepts nothing (full, over quota, read-only, broken) raises StoreError and leaves the old version.  The
first refusal of an outage is logged, and so is its end; `trouble` says for `fieldrig status` what is wrong.
"""

import logging
import mmap
import os
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from errno import EINVAL, EOPNOTSUPP, EPERM
from pathlib import Path
from typing import IO, Final, Generic, NamedTuple, Protocol, TypeVar

from fieldrig.errors import RigError
from fieldrig.storage import store_format
from fieldrig.system.own_files import open_file, open_own, own_folder
from fieldrig.system.whole_file import sync_folder

T = TypeVar("T")

log = logging.getLogger(__name__)

PREVIOUS: Final = ".previous"
DAMAGED: Final = ".damaged"
ASIDE: Final = ".new"
RAM: Final = ".ram"


class StoreError(OSError):
    """The store cannot save the data; the data saved before is still there."""


class Version(NamedTuple):
    """One saved version."""

    place: str
    """The name of its file, for messages."""
    data: bytes | None
    """The data; None if it is damaged."""
    wrong: str = ""
    """The reason if it is damaged."""


class Store(Protocol):
    """The non-volatile memory of one device."""

    def load(self) -> bytes | None:
        """Return the newest version that is not damaged; None without one."""

    def versions(self) -> Sequence[Version]:
        """Return every version that is still there, newest first.  Empty if nothing was ever saved."""

    def save(self, data: bytes) -> None:
        """Save `data`.  When this returns, it survives SIGKILL and power-off; until then, the old data does.

        StoreError if it cannot be saved; the old data is kept then.
        """

    def buffered_ram(self, size: int) -> memoryview:
        """Return `size` bytes that keep what is written to them at every instant, even over SIGKILL.  They start as
        zeros.

        A SIGKILL never tears an aligned word of 4 bytes.  Every call returns the same bytes.  StoreError if the disk
        has no room for them.
        """


class Part(ABC):
    """Base of a part of another store; checksum and previous version belong to the whole."""

    @abstractmethod
    def load(self) -> bytes | None: ...

    def versions(self) -> Sequence[Version]:
        data = self.load()
        return [] if data is None else [Version("its part of the memory", data)]


class Restored(NamedTuple, Generic[T]):
    """The result of `restore`."""

    content: T | None
    """The content; None if nothing was ever saved, or no version can be used."""
    is_damaged: bool
    """True if the newest version cannot be used."""


def restore(store: Store, decode: Callable[[bytes], T]) -> Restored[T]:
    """Return the newest version that `decode` accepts.

    `decode` raises ValueError for data that the device cannot have saved, such as a value outside its limits; this
    counts as damage too.  Damage is logged.
    """
    is_damaged = False
    for version in store.versions():
        wrong = version.wrong
        if version.data is not None:
            try:
                content = decode(version.data)
            except ValueError as cause:
                wrong = f"its content cannot be used: {cause}"
            else:
                if is_damaged:
                    log.warning("%s is used instead", version.place)
                return Restored(content, is_damaged)
        log.warning("%s is damaged: %s", version.place, wrong)
        is_damaged = True
    if is_damaged:
        log.warning("no version of what was stored can be used: starting with the defaults")
    return Restored(None, is_damaged)


class MemoryStore:
    """A store in memory, for virtual time and tests; a power cycle there is a new device on the old store."""

    def __init__(self, data: bytes | None = None) -> None:
        self._saved = [] if data is None else [data]
        self._ram = bytearray()

    def load(self) -> bytes | None:
        return self._saved[0] if self._saved else None

    def versions(self) -> Sequence[Version]:
        return [Version(name, data) for name, data in zip(("memory", "memory" + PREVIOUS), self._saved, strict=False)]

    def save(self, data: bytes) -> None:
        self._saved = [data, *self._saved[:1]]

    def buffered_ram(self, size: int) -> memoryview:
        if len(self._ram) < size:
            self._ram = self._ram + bytes(size - len(self._ram))  # another one, for views of the old hold its size
        return memoryview(self._ram)[:size]


class FileStore:
    """A store in files.  `path` is the newest version; the previous one, a damaged one and buffered RAM are beside it.

    `owner` is the kind of the device; a store of another kind counts as damaged.
    """

    def __init__(self, path: Path, owner: str = "", on_trouble: Callable[[str], None] = lambda _why: None) -> None:
        """`on_trouble` is called with the reason when an outage begins, and with "" when it is over."""
        self._path, self._owner, self._on_trouble = path, owner, on_trouble
        self._is_whole = False
        """True if the newest version is known to be undamaged."""
        self._refused: dict[str, _Refusal] = {}

    def trouble(self) -> str:
        """Return why data cannot be saved at present; empty if it can.

        Refused data is tried again, so the answer is also right if the device saves nothing more.  Buffered RAM is only
        available again after the device has asked for it.
        """
        refusal = self._refused.get(ASIDE)
        if refusal is not None:
            with suppress(StoreError), self._taking(ASIDE, refusal.size):
                self._write_aside(bytes(refusal.size)).unlink()
        return "; ".join(dict.fromkeys(refusal.why for refusal in self._refused.values()))

    def load(self) -> bytes | None:
        return restore(self, bytes).content

    def versions(self) -> Sequence[Version]:
        whole = [version for version in map(self._read, (self._path, self._beside(PREVIOUS))) if version is not None]
        return whole or ([] if (lost := self._read(self._beside(DAMAGED))) is None else [lost._replace(data=None)])

    def save(self, data: bytes) -> None:
        blob = store_format.encode(self._owner, data)
        with self._taking(ASIDE, len(blob)):
            aside = self._write_aside(blob)
            self._keep_the_old()
            aside.replace(self._path)
            self._is_whole = True
        sync_folder(self._path.parent)

    def buffered_ram(self, size: int) -> memoryview:
        path = self._beside(RAM)
        with self._taking(RAM, size):
            self._own_parent()
            fd = open_own(path, os.O_RDWR | os.O_CREAT)
            try:
                _allocate(fd, size)
                return memoryview(mmap.mmap(fd, size))
            finally:
                os.close(fd)

    def _beside(self, suffix: str) -> Path:
        return self._path.with_suffix(suffix) if suffix == RAM else self._path.with_name(self._path.name + suffix)

    def _write_aside(self, blob: bytes) -> Path:
        aside = self._beside(ASIDE)
        self._own_parent()
        with open_file(aside, "wb") as file:
            _put_through(file, blob)
        return aside

    def _own_parent(self) -> None:
        """Make the folder, for this user only: what a device keeps may be a password."""
        try:
            own_folder(self._path.parent)
        except RigError as cause:
            raise PermissionError(EPERM, cause.what, str(self._path)) from cause

    def _read(self, path: Path) -> Version | None:
        try:
            with open_file(path, "rb") as file:
                blob = file.read(store_format.LONGEST + 1)
            if len(blob) > store_format.LONGEST:
                return Version(str(path), None, "it is too long")
            return Version(str(path), store_format.decode(self._owner, blob))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as cause:
            return Version(str(path), None, str(cause))

    def _keep_the_old(self) -> None:
        """Keep the present version as the previous one, or move it aside for analysis if it is damaged."""
        if not self._is_whole:
            last = self._read(self._path)
            if last is None:
                return
            self._is_whole = last.data is not None
        self._path.replace(self._beside(PREVIOUS if self._is_whole else DAMAGED))

    @contextmanager
    def _taking(self, suffix: str, size: int) -> Iterator[None]:
        try:
            yield
        except OSError as cause:
            if suffix == ASIDE:
                with suppress(OSError):
                    self._beside(ASIDE).unlink(missing_ok=True)
            self._note_refused(suffix, _Refusal(cause.strerror or str(cause), size))
            raise StoreError(cause.errno, cause.strerror, str(self._path)) from cause
        self._note_taken(suffix)

    def _note_refused(self, suffix: str, refusal: "_Refusal") -> None:
        if suffix not in self._refused:
            log.warning("%s cannot be stored: %s; the old content is kept", self._path, refusal.why)
        if not self._refused:
            self._on_trouble(refusal.why)
        self._refused[suffix] = refusal

    def _note_taken(self, suffix: str) -> None:
        if self._refused.pop(suffix, None) is not None:
            log.info("%s can be stored again", self._path)
            if not self._refused:
                self._on_trouble("")


class _Refusal(NamedTuple):
    why: str
    size: int
    """Number of bytes for which there was no room."""


def _put_through(file: IO[bytes], data: bytes) -> None:
    file.write(data)
    file.flush()
    os.fsync(file.fileno())


def _allocate(fd: int, size: int) -> None:
    """Allocate `size` bytes on the disk: a write to a mapped hole of a full disk would kill the process."""
    if hasattr(os, "posix_fallocate"):
        try:
            os.posix_fallocate(fd, 0, size)
        except OSError as cause:
            if cause.errno not in (EOPNOTSUPP, EINVAL):
                raise
        else:
            return
    there = os.fstat(fd).st_size
    os.lseek(fd, there, os.SEEK_SET)
    while there < size:
        there += os.write(fd, bytes(size - there))
