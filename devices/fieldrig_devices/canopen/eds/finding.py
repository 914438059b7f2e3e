"""A finding of the EDS check: where it is, what is wrong, and what was expected."""

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
    """True if no node can be made from the file because of it."""

    @property
    def place(self) -> str:
        """Section and key, without those that are empty."""
        return " ".join(part for part in (f"[{self.section}]" if self.section else "", self.key) if part)

    def __str__(self) -> str:
        place = f"{self.place}: " if self.place else ""
        return f"{self.line}: {self.severity.value}: {place}{self.what}; {self.remedy}"


def error(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.ERROR, line, section, key, what, remedy)


def warning(line: int, section: str, key: str, what: str, remedy: str) -> Finding:
    return Finding(Severity.WARNING, line, section, key, what, remedy)


NO_OBJECT = Finding(Severity.ERROR, 1, "", "", "the file has no object", "add at least one, such as [1000]", True)
"""The only finding by which a file is refused."""
