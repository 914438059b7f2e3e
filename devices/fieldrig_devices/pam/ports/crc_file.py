"""PAM_VME.H of the original compiler: lines `#define <identifier> <CRC>` (manual lines 9567 to 9575)."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Final

_LINE: Final = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+\(?(0[xX][0-9a-fA-F]{1,4}|\d{1,5})\b", re.MULTILINE)


def crcs_in(path: Path) -> Mapping[str, int]:
    """Return the CRC of each variable; the numbers in the file are decimal or begin with 0x.

    ValueError if there is none.
    """
    lines = _LINE.findall(path.read_text(encoding="latin-1"))
    if not lines:
        raise ValueError("the file has no line such as #define DFI_Start 0x1A2B, with the CRC of a variable")
    return {name: int(number, 16 if number[1:2] in ("x", "X") else 10) & 0xFFFF for name, number in lines}
