"""The commands of FTP that need a data connection (RFC 959, 4.1.3)."""

from collections.abc import Sequence

from fieldrig_devices.ftp.files import Files
from fieldrig_devices.ftp.replies import Reply, refused


class Send:
    """RETR, LIST and NLST: bytes to the client."""

    def __init__(self, content: bytes) -> None:
        self._content = content

    def content(self) -> bytes:
        return self._content

    def done(self, received: bytes) -> str:
        return Reply.TRANSFERRED

    def limit(self) -> int:
        return 0


class Store:
    """STOR: a file from the client, which is written when it is complete."""

    def __init__(self, files: Files, name: str) -> None:
        self._files, self._name = files, name

    def content(self) -> None:
        return None

    def done(self, received: bytes) -> str:
        try:
            self._files.write(self._name, received)
        except ValueError as cause:
            return refused(552, cause)
        return Reply.TRANSFERRED

    def limit(self) -> int:
        """The free space, with that of the file which is replaced."""
        before = len(self._files.read(self._name)) if self._name in self._files.names else 0
        return self._files.free + before + SLACK


SLACK = 4096
"""Bytes beyond the free space that are still received; the disk itself refuses a file that is too large."""


def long_list(files: Files, names: Sequence[str]) -> bytes:
    """Return a LIST in the form of Unix, which clients read; the controller keeps no dates."""
    lines = [f"-rw-rw-rw-   1 max4     max4     {len(files.read(name)):>10} Jan 01  2003 {name}\r\n" for name in names]
    return "".join(lines).encode()


def short_list(names: Sequence[str]) -> bytes:
    return "".join(f"{name}\r\n" for name in names).encode()
