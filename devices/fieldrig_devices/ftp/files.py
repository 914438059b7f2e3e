"""The files of a device, as its FTP server sees them."""

from typing import Protocol


class Files(Protocol):
    """One folder of files.  Each method raises ValueError, with the reason in its first line, if it fails."""

    @property
    def names(self) -> list[str]:
        """Names as a client sees them, such as `INDEX.HTM`."""

    @property
    def free(self) -> int:
        """Number of bytes that are free."""

    def name_of(self, path: str) -> str:
        """Return the name in its form on the disk.  ValueError for a name that no file can have."""

    def read(self, name: str) -> bytes: ...

    def write(self, name: str, data: bytes) -> None: ...

    def delete(self, name: str) -> None: ...

    def rename(self, name: str, new: str) -> None: ...
