"""The flash disk as FTP shows it: one folder, names without the backslash.

Source: PacDrive manual 5217 (digest PD-282).  The limits are those of the disk; hidden files are not reachable.
"""

from fieldrig_devices.max4.storage.disk import FlashDisk, file_name


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
        return file_name("\\" + path.removeprefix("/"))[1:]

    def read(self, name: str) -> bytes:
        return self._disk.read("\\" + name)

    def write(self, name: str, data: bytes) -> None:
        self._disk.write("\\" + name, data)

    def delete(self, name: str) -> None:
        self._disk.delete("\\" + name)

    def rename(self, name: str, new: str) -> None:
        self._disk.rename("\\" + name, "\\" + new)
