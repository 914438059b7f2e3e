"""The commissioning of a DCF: the node and the bit rate that it was made for.

Source: CiA 306-1 6.2.2.  The standard spells the name of the section with one m, and files have both.
"""

import re
from pathlib import Path
from typing import NamedTuple

from fieldrig_devices.canopen.eds.source import parse_number

SECTION = re.compile(r"(?ims)^[ \t]*\[DeviceComm?issioning\](.*?)(?=^[ \t]*\[|\Z)")
KEY = re.compile(r"(?m)^[ \t]*(\w+)[ \t]*=[ \t]*(\w+)")


class Commissioning(NamedTuple):
    """Node and bit rate of a DCF; None for what it does not say, and for everything of an EDS."""

    node_id: int | None
    bit_rate: int | None
    """In bit/s."""


def commissioned(file: Path) -> Commissioning:
    """Return the commissioning of a file.  OSError if it cannot be read."""
    section = SECTION.search(file.read_text(encoding="latin-1"))
    keys = dict(KEY.findall(section[1].lower())) if section else {}
    node_id, kilobits = _number(keys.get("nodeid", "")), _number(keys.get("baudrate", ""))
    return Commissioning(node_id if 1 <= node_id <= 127 else None, kilobits * 1000 if 10 <= kilobits <= 1000 else None)


def _number(text: str) -> int:
    try:
        return parse_number(text)
    except ValueError:
        return 0
