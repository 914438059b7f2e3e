"""The CRCs of the original compiler, read from its PAM_VME.H (manual lines 9567 to 9575)."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

from fieldrig_devices.pam.language.ports import PortVariable
from fieldrig_devices.pam.ports.options import PortOptions

_LINE: Final = re.compile(r"^[ \t]*#[ \t]*define[ \t]+(\w+)[ \t]+\(?(0[xX][0-9a-fA-F]{1,4}|\d{1,5})\b", re.MULTILINE)


def crcs_in(path: Path) -> Mapping[str, int]:
    """Return the CRC of each variable in a PAM_VME.H, whose numbers are decimal or begin with 0x."""
    text = path.read_text(encoding="latin-1")
    return {name: int(number, 16 if number[1:2] in ("x", "X") else 10) & 0xFFFF for name, number in _LINE.findall(text)}


def with_crcs(variables: Iterable[PortVariable], options: PortOptions) -> tuple[PortVariable, ...]:
    """Return the variables with the CRCs of the settings; a variable that the file lacks keeps its own."""
    given = crcs_in(options.pam_vme_h) if options.pam_vme_h is not None else {}
    return tuple(replace(variable, given_crc=given.get(variable.name)) for variable in variables)
