"""The elementary types: sizes, ranges and units.

Source: PacDrive manual 640 to 951 (digest 2.2), and IEC 61131-3:2013, table 10.
"""

from enum import Enum
from typing import Final


class Family(Enum):
    BOOL = "BOOL"
    BITS = "bit string"
    SIGNED = "signed integer"
    UNSIGNED = "unsigned integer"
    REAL = "real number"
    TIME = "duration"
    DATE = "date"
    CHARACTER = "character"


_TWINS: Final = {
    "SIGNED_TIME": "TIME",
    "UNSIGNED_LTIME": "LTIME",
    "UNSIGNED_LDATE": "LDATE",
    "UNSIGNED_LDT": "LDT",
}
"""The types that have the name of another one in their dialects."""
_DAY_NS: Final = 86_400_000_000_000
_FACTS: Final = {
    "BOOL": (1, Family.BOOL, 0, 1),
    "BYTE": (1, Family.BITS, 0, 2**8 - 1),
    "WORD": (2, Family.BITS, 0, 2**16 - 1),
    "DWORD": (4, Family.BITS, 0, 2**32 - 1),
    "LWORD": (8, Family.BITS, 0, 2**64 - 1),
    "SINT": (1, Family.SIGNED, -(2**7), 2**7 - 1),
    "INT": (2, Family.SIGNED, -(2**15), 2**15 - 1),
    "DINT": (4, Family.SIGNED, -(2**31), 2**31 - 1),
    "LINT": (8, Family.SIGNED, -(2**63), 2**63 - 1),
    "USINT": (1, Family.UNSIGNED, 0, 2**8 - 1),
    "UINT": (2, Family.UNSIGNED, 0, 2**16 - 1),
    "UDINT": (4, Family.UNSIGNED, 0, 2**32 - 1),
    "ULINT": (8, Family.UNSIGNED, 0, 2**64 - 1),
    "REAL": (4, Family.REAL, 0, 0),
    "LREAL": (8, Family.REAL, 0, 0),
    "TIME": (4, Family.TIME, 0, 2**32 - 1),
    "DATE": (4, Family.DATE, 0, 2**32 - 1),
    "TOD": (4, Family.DATE, 0, 86_399_999),
    "DT": (4, Family.DATE, 0, 2**32 - 1),
    "LTIME": (8, Family.TIME, -(2**63), 2**63 - 1),
    "LDATE": (8, Family.DATE, -106_751 * _DAY_NS, 106_751 * _DAY_NS),
    "LTOD": (8, Family.DATE, 0, _DAY_NS - 1),
    "LDT": (8, Family.DATE, -(2**63), 2**63 - 1),
    "CHAR": (1, Family.CHARACTER, 0, 2**8 - 1),
    "WCHAR": (2, Family.CHARACTER, 0, 2**16 - 1),
    "SIGNED_TIME": (4, Family.TIME, -(2**31), 2**31 - 1),
    "UNSIGNED_LTIME": (8, Family.TIME, 0, 2**64 - 1),
    "UNSIGNED_LDATE": (8, Family.DATE, 0, 213_503 * _DAY_NS),
    "UNSIGNED_LDT": (8, Family.DATE, 0, 2**64 - 1),
}
"""Size in bytes, family, and the smallest and the largest value."""


class Elementary(Enum):
    """The elementary types by their names."""

    BOOL = "BOOL"
    BYTE = "BYTE"
    WORD = "WORD"
    DWORD = "DWORD"
    LWORD = "LWORD"
    SINT = "SINT"
    INT = "INT"
    DINT = "DINT"
    LINT = "LINT"
    USINT = "USINT"
    UINT = "UINT"
    UDINT = "UDINT"
    ULINT = "ULINT"
    REAL = "REAL"
    LREAL = "LREAL"
    TIME = "TIME"
    """In milliseconds."""
    DATE = "DATE"
    """In seconds since 1970-01-01, at midnight."""
    TOD = "TOD"
    """In milliseconds since midnight."""
    DT = "DT"
    """In seconds since 1970-01-01."""
    LTIME = "LTIME"
    """In nanoseconds, with a sign."""
    LDATE = "LDATE"
    """In nanoseconds since 1970-01-01, at midnight."""
    LTOD = "LTOD"
    """In nanoseconds since midnight."""
    LDT = "LDT"
    """In nanoseconds since 1970-01-01."""
    CHAR = "CHAR"
    """The code of a character of a STRING."""
    WCHAR = "WCHAR"
    """The code of a character of a WSTRING."""
    SIGNED_TIME = "SIGNED_TIME"
    """The TIME of a dialect in which times may be negative, in milliseconds."""
    UNSIGNED_LTIME = "UNSIGNED_LTIME"
    """The LTIME of CODESYS and TwinCAT, in nanoseconds."""
    UNSIGNED_LDATE = "UNSIGNED_LDATE"
    UNSIGNED_LDT = "UNSIGNED_LDT"
    """The LDATE and LDT of the same tools, up to the year 2554."""

    def __init__(self, _: str) -> None:
        self.size, self.family, self.low, self.high = _FACTS[self.value]

    size: int
    """In bytes."""
    family: Family
    low: int
    high: int
    """The smallest and the largest value of integers, bit strings, times and characters; 0 for real numbers."""

    @property
    def bits(self) -> int:
        return 1 if self.family is Family.BOOL else self.size * 8

    @property
    def is_integer(self) -> bool:
        """True for types that integer arithmetic applies to: integers and bit strings."""
        return self.family in (Family.BITS, Family.SIGNED, Family.UNSIGNED)

    @property
    def is_real(self) -> bool:
        return self.family is Family.REAL

    @property
    def is_signed(self) -> bool:
        """True for an integer or time that may be below 0."""
        return self.low < 0

    @property
    def is_time(self) -> bool:
        """True for a duration, a date, a time of day, or a date with a time."""
        return self.family in (Family.TIME, Family.DATE)

    @property
    def initial(self) -> bool | int | float:
        """The value without a declared start value (PD-056)."""
        return False if self.family is Family.BOOL else 0.0 if self.is_real else 0

    def __str__(self) -> str:
        return _TWINS.get(self.name, self.name)


ALIASES: Final = {"TIME_OF_DAY": Elementary.TOD, "DATE_AND_TIME": Elementary.DT}
LONG_ALIASES: Final = {"LTIME_OF_DAY": Elementary.LTOD, "LDATE_AND_TIME": Elementary.LDT}
LONGER: Final = {
    Elementary.TIME: Elementary.LTIME,
    Elementary.SIGNED_TIME: Elementary.LTIME,
    Elementary.DATE: Elementary.LDATE,
    Elementary.TOD: Elementary.LTOD,
    Elementary.DT: Elementary.LDT,
}
"""The types of edition 3 that have the same times and dates in nanoseconds."""
SHORT_TIMES: Final = (Elementary.TIME, Elementary.SIGNED_TIME)
"""The two forms of TIME, of which a dialect has one in its programs; functions of the libraries may have the other."""
LONG_TIMES: Final = (Elementary.LTIME, Elementary.UNSIGNED_LTIME)
"""The two forms of LTIME."""
UNSIGNED: Final = {
    Elementary.LTIME: Elementary.UNSIGNED_LTIME,
    Elementary.LDATE: Elementary.UNSIGNED_LDATE,
    Elementary.LDT: Elementary.UNSIGNED_LDT,
}
"""The types without a sign that the tools of today have instead of those of the standard."""
_SIGNED: Final = {unsigned: signed for signed, unsigned in UNSIGNED.items()}
OF_EDITION_3: Final = frozenset({*LONGER.values(), *UNSIGNED.values(), Elementary.CHAR, Elementary.WCHAR})
"""Types whose names are free for others before edition 3."""


def are_twins(kind: Elementary, other: Elementary) -> bool:
    """True for the two forms, with and without a sign, of one long type."""
    return _SIGNED.get(kind, kind) is _SIGNED.get(other, other)


def is_longer(kind: Elementary, other: Elementary) -> bool:
    """True if `other` has the same times or dates as `kind`, in nanoseconds."""
    return LONGER.get(kind) is _SIGNED.get(other, other)


UNITS_NS: Final = {
    Elementary.TIME: 1_000_000,
    Elementary.SIGNED_TIME: 1_000_000,
    Elementary.TOD: 1_000_000,
    Elementary.DATE: 1_000_000_000,
    Elementary.DT: 1_000_000_000,
    **dict.fromkeys(LONGER.values(), 1),
    **dict.fromkeys(UNSIGNED.values(), 1),
}
"""Duration of one count of each type of times and dates, in nanoseconds."""
