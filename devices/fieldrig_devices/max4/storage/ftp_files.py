"""The flash disk as FTP shows it: one folder, names without the backslash.

Source: PacDrive manual 5217 (digest PD-282).  The limits are those of the disk; hidden files are not reachable.  A name
may have the backslash of the manual, and its rules are stricter than the disk's, so that pages have plain addresses.
"""

import re
from typing import Final

from fieldrig_devices.max4.storage.disk import FlashDisk, file_name

_PLACE: Final = re.compile(r"(?:\.?[/\\])*")
"""The only folder, as clients write it before a name: `/`, `\\` or `./`."""
_NAME: Final = re.compile(r"(?=.*[A-Z0-9])[A-Z0-9.]+")


class FtpFiles:
    """The `Files` of one flash disk."""

    def __init__(self, disk: FlashDisk) -> None:
        self._disk = disk

    @property
    def names(self) -> list[str]:
        return [name[1:] for name in self._disk.names]

    @property
    def free(self) -> int:
        return self._disk.free

    def name_of(self, path: str) -> str:
        name = file_name("\\" + _PLACE.sub("", path, count=1))[1:]
        if _NAME.fullmatch(name) is None and name not in self.names:  # a program may have written any name
            raise ValueError(f"expected a file name of letters, digits and points, got {name!r}")
        return name

    def read(self, name: str) -> bytes:
        return self._disk.read("\\" + name)

    def write(self, name: str, data: bytes) -> None:
        self._disk.write("\\" + name, data)

    def delete(self, name: str) -> None:
        self._disk.delete("\\" + name)

    def rename(self, name: str, new: str) -> None:
        self._disk.rename("\\" + name, "\\" + new)
