"""Times as texts of ISO 8601, `2026-01-31T08:30:00.1234567`, for the times that Tc3_JsonXml writes and reads."""

import re
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Final

_FORM: Final = re.compile(r"(\d{4}-\d\d-\d\d)T(\d\d:\d\d:\d\d)(?:[.,](\d+))?(Z|[+-]\d\d:?\d\d)?", re.ASCII)


@dataclass(frozen=True, slots=True)
class Clock:
    """A type of time: when it begins, and the number of digits behind the point of a second."""

    epoch: datetime
    digits: int

    def text(self, value: int) -> str:
        """Return the text of a time; an empty one beyond the year 9999."""
        seconds, rest = divmod(value, 10**self.digits)
        try:
            whole = (self.epoch + timedelta(seconds=seconds)).replace(tzinfo=None).isoformat(timespec="seconds")
        except OverflowError:
            return ""
        return f"{whole}.{rest:0{self.digits}}" if self.digits else whole

    def value(self, text: str) -> int:
        """Return the time of a text; 0 if it has none, or one before this type begins."""
        found = _FORM.fullmatch(text)
        if found is None:
            return 0
        day, clock, fraction, zone = found.groups()
        try:
            given = datetime.fromisoformat(f"{day}T{clock}Z") - _offset(zone or "Z")
        except (ValueError, OverflowError):
            return 0
        seconds = (given - self.epoch) // timedelta(seconds=1)
        part = int((fraction or "").ljust(self.digits, "0")[: self.digits] or 0)
        scale: int = 10**self.digits
        return max(0, seconds * scale + part)


DATE_AND_TIME: Final = Clock(datetime(1970, 1, 1, tzinfo=UTC), 0)
DCTIME: Final = Clock(datetime(2000, 1, 1, tzinfo=UTC), 9)
FILETIME: Final = Clock(datetime(1601, 1, 1, tzinfo=UTC), 7)
CLOCKS: Final = {"DateTime": DATE_AND_TIME, "DcTime": DCTIME, "FileTime": FILETIME}
"""The types of time by the words in the names of methods."""


def is_time(text: str) -> bool:
    """True for a text of this form."""
    return _FORM.fullmatch(text) is not None


def _offset(zone: str) -> timedelta:
    if zone == "Z":
        return timedelta()
    minutes = int(zone[1:3]) * 60 + int(zone[-2:])
    return timedelta(minutes=-minutes if zone[0] == "-" else minutes)
