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
    is_refused: bool = False
    """True if it leaves an object without a meaning, so that no node can be made from the file."""

    @property
    def place(self) -> str:
        """Section and key, as far as there are any."""
        return " ".join(part for part in (f"[{self.section}]" if self.section else "", self.key) if part)

    def __str__(self) -> str:
        place = f"{self.place}: " if self.place else ""
        return f"{self.line}: {self.severity.value}: {place}{self.what}; {self.remedy}"


def error(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.ERROR, line, section, key, what, remedy)


def refusal(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.ERROR, line, section, key, what, remedy, is_refused=True)


def warning(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.WARNING, line, section, key, what, remedy)
