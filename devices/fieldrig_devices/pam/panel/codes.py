"""Message codes of a PAM: eight characters O O R X T N N N (PAMS-045)."""

import re
from dataclasses import dataclass
from enum import Enum
from typing import Final

MOST_NUMBER: Final = 0xFFF


class Kind(Enum):
    """The types of messages, by their letter."""

    MESSAGE = "M"
    WARNING = "W"
    END_WARNING = "K"
    ERROR = "E"
    END_ERROR = "S"
    FATAL = "F"


LISTED: Final = frozenset({Kind.END_WARNING, Kind.FATAL, Kind.ERROR, Kind.END_ERROR})
"""The kinds that the error list stores (manual line 8550)."""
ENDS: Final = {Kind.END_WARNING: Kind.WARNING, Kind.END_ERROR: Kind.ERROR}
"""The condition that each kind of end belongs to; both have the same number."""

WORKSPACE_OVERRUN: Final = (3, Kind.ERROR, 0x02C)

_FORM: Final = re.compile(r"([0-9A-F]{2})(\.\.|[08]0)([MWKESF])([0-9A-F]{3})")
_BOOT: Final = 1
_KERNEL: Final = 2
_FAULT_HANDLER: Final = 0xFF0
"""The first number of the fault handler, whose codes are not of real time (table 12-8)."""


@dataclass(frozen=True, slots=True)
class Code:
    """A message code without its unused digit X, which is 0."""

    origin: int
    kind: Kind
    number: int
    is_real_time: bool = True

    def __str__(self) -> str:
        return f"{self.origin:02X}{8 * self.is_real_time}0{self.kind.value}{self.number:03X}"

    @property
    def is_fatal(self) -> bool:
        """True for what ends the application: fatal errors, and the overrun of a workspace, an E (PAMS-062)."""
        return self.kind is Kind.FATAL or (self.origin, self.kind, self.number) == WORKSPACE_OVERRUN

    @property
    def ended(self) -> "Code | None":
        """The code of the condition that this message ends; None if it is no end."""
        kind = ENDS.get(self.kind)
        return None if kind is None else Code(self.origin, kind, self.number, self.is_real_time)


def code_of(text: str) -> Code:
    """Return the code in a text such as `0780E01E` or `07..E01E`.  ValueError for any other text.

    The two dots stand for the digits R and X.  Codes of the boot and of the fault handler are not of real time.
    """
    match = _FORM.fullmatch(text)
    if match is None:
        raise ValueError(f"{text!r} is not a message code, such as 0780E01E")
    origin, number = int(match[1], 16), int(match[4], 16)
    is_real_time = match[2] == "80"
    if match[2] == "..":
        is_real_time = origin != _BOOT and not (origin == _KERNEL and number >= _FAULT_HANDLER)
    return Code(origin, Kind(match[3]), number, is_real_time)
