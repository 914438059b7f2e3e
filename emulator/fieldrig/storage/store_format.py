"""The one format of every file in which a device's store keeps data: a line of text, then the data as they are.

    FIELDRIG-STORE 1 5F2A91C0 143 canopen.node
    {"version": 1, ...

The line holds the magic word, the version of the format, a checksum, the length of the data in bytes, and the owner,
which is the kind of the device.  The checksum is the CRC-32 of IEEE 802.3 over everything behind it.
"""

import re
import zlib
from typing import Final

MAGIC: Final = b"FIELDRIG-STORE"
VERSION: Final = 1
LONGEST: Final = 64 << 20
"""Longest file in bytes; a longer one is not read."""
_HEAD: Final = re.compile(rb"FIELDRIG-STORE (\d{1,9}) ([0-9A-F]{8}) (\d{1,9}) ([^\n]*)\n")


def encode(owner: str, data: bytes) -> bytes:
    checked = b"%d %s\n%b" % (len(data), owner.encode(), data)
    return b"%b %d %08X %b" % (MAGIC, VERSION, zlib.crc32(checked), checked)


def decode(owner: str, blob: bytes) -> bytes:
    """Return the data.  ValueError, with the reason, for a file that `encode` does not write for this owner."""
    head = _HEAD.match(blob)
    if head is None:
        raise ValueError("it is not a file of a store")
    version, _, length, stored_for = head.groups()
    if int(version) != VERSION:
        raise ValueError(f"it has version {int(version)} of the format, expected {VERSION}")
    data = blob[head.end() :]
    if len(data) != int(length):
        raise ValueError(f"it has {len(data)} bytes of data, expected {int(length)}")
    if blob != encode(owner, data):
        if blob == encode(stored_for.decode(errors="replace"), data):
            raise ValueError(f"it belongs to {stored_for.decode()!r}, expected {owner!r}")
        raise ValueError("its checksum is wrong")
    return data
