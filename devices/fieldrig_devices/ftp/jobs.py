"""The commands of FTP that need a data connection (RFC 959, 4.1.3)."""

from typing import Final

from fieldrig_devices.ftp.files import Files
from fieldrig_devices.ftp.replies import Reply, refused

SLACK: Final = 4096
"""Bytes beyond the free space that are still received; the disk itself refuses a file that is too large."""


class RestartError(ValueError):
    """A transfer cannot begin where the client wants it to."""


class ForbiddenNameError(ValueError):
    """A file cannot have this name."""


class Send:
    """RETR, LIST, NLST and MLSD: bytes to the client."""

    def __init__(self, content: bytes) -> None:
        self._content = content

    def content(self) -> bytes:
        return self._content

    def done(self, received: bytes) -> str:
        return Reply.TRANSFERRED

    def limit(self) -> int:
        return 0


class Store:
    """STOR and APPE: a file from the client, which is written when it is complete."""

    def __init__(self, files: Files, name: str, kept: bytes = b"") -> None:
        """`kept` is the beginning of the file that stays before what the client sends."""
        self._files, self._name, self._kept = files, name, kept

    def content(self) -> None:
        return None

    def done(self, received: bytes) -> str:
        try:
            self._files.write(self._name, self._kept + received)
        except ValueError as cause:
            return refused(552, cause)
        return Reply.TRANSFERRED

    def limit(self) -> int:
        """The free space, with that of the part which is replaced."""
        return self._files.free + len(content_of(self._files, self._name)) - len(self._kept) + SLACK


def content_of(files: Files, name: str) -> bytes:
    """Return the content of a file; no bytes if it does not exist."""
    return files.read(name) if name in files.names else b""


def rest_of(content: bytes, start: int) -> bytes:
    """Return the content from a byte on.  RestartError if it is behind the end."""
    _check(content, start)
    return content[start:]


def beginning_of(content: bytes, end: int) -> bytes:
    """Return the content up to a byte.  RestartError if it is behind the end."""
    _check(content, end)
    return content[:end]


def _check(content: bytes, place: int) -> None:
    if place > len(content):
        raise RestartError(f"expected a restart at 0 to {len(content)}, the size of the file, got {place}")
