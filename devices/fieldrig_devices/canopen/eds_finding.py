"""What a check of an EDS file finds: where, what is wrong, and what would be right."""

from enum import Enum
from typing import NamedTuple


class Severity(Enum):
    ERROR = "error"
    WARNING = "warning"


class Finding(NamedTuple):
    severity: Severity
    line: int
    section: str
    key: str
    what: str
    remedy: str

    def __str__(self) -> str:
        where = " ".join(part for part in (f"[{self.section}]" if self.section else "", self.key) if part)
        return f"{self.line}: {self.severity.value}: {where + ': ' if where else ''}{self.what}; {self.remedy}"


def error(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.ERROR, line, section, key, what, remedy)


def warning(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.WARNING, line, section, key, what, remedy)
