"""Bytes as text that a person can read, with control characters by name.

Source: ECMA-48 (ISO/IEC 6429), 8.2: the names of the C0 set, and DEL.
"""

from collections.abc import Mapping
from typing import Final

LONGEST: Final = 80
"""Bytes that are shown of one message."""
CONTROLS: Final = (
    "NUL", "SOH", "STX", "ETX", "EOT", "ENQ", "ACK", "BEL", "BS", "HT", "LF", "VT", "FF", "CR", "SO", "SI",
    "DLE", "DC1", "DC2", "DC3", "DC4", "NAK", "SYN", "ETB", "CAN", "EM", "SUB", "ESC", "IS4", "IS3", "IS2", "IS1",
)  # fmt: skip
"""Their codes are 00h to 1Fh."""
_NAMES: Final[Mapping[int, str]] = {
    **{code: f"<{name}>" for code, name in enumerate(CONTROLS)},
    0x7F: "<DEL>",
    **{code: f"<{code:02X}h>" for code in range(0x80, 0x100)},
}
_USUAL: Final = frozenset((*range(0x20, 0x7F), *b"\t\r\n\x08\x0c\x1b\x11\x13"))
"""Characters of a text: what is printed, and what moves the cursor or holds the sender."""


def readable(data: bytes) -> str:
    """Return printable ASCII as it is, control characters by their names, and others in hex, such as `AT<CR>`."""
    shown = data[:LONGEST].decode("latin-1").translate(_NAMES)
    return shown + (f" … {len(data)} bytes" if len(data) > LONGEST else "")


def is_text(data: bytes) -> bool:
    """Return whether most of the bytes are characters of a text."""
    return 4 * sum(byte in _USUAL for byte in data) >= 3 * len(data)


def text_or_hex(data: bytes) -> str:
    """Return a text as it can be read, and anything else in hex."""
    if is_text(data):
        return readable(data)
    return data[:LONGEST].hex(" ").upper() + (f" … {len(data)} bytes" if len(data) > LONGEST else "")
