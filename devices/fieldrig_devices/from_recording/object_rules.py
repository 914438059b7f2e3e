"""Access and limits of an object, as far as a recording shows them."""

from fieldrig_devices.canopen.abort import Code
from fieldrig_devices.canopen.datatypes import DataType, Integer
from fieldrig_devices.from_recording.objects import ObjectLog
from fieldrig_devices.from_recording.pdos import Pdo

Value = int | str
"""A start value in an EDS: a number, or a text such as one with $NODEID."""


def limits_of(log: ObjectLog, type: DataType, start: Value) -> tuple[int | None, int | None]:
    """Return the limits that explain which values were refused as too low and as too high; None for no limit."""
    if not isinstance(type, Integer) or not isinstance(start, int):
        return None, None
    valid = [type.decode(data) for data in log.accepted if len(data) == type.size] + [start]
    refused = {
        code: [type.decode(data) for other, data in log.refused_writes if other == code and len(data) == type.size]
        for code in (Code.VALUE_TOO_LOW, Code.VALUE_TOO_HIGH)
    }
    low = max((value + 1 for value in refused[Code.VALUE_TOO_LOW]), default=None)
    high = min((value - 1 for value in refused[Code.VALUE_TOO_HIGH]), default=None)
    low = None if low is None or low > min(valid) else low
    return low, None if high is None or high < max(valid) else high


def access_of(log: ObjectLog, known: str) -> str:
    """Return the access that the recording shows, else that of the standard."""
    if log.is_written:
        is_unreadable = not log.is_read and (False, int(Code.WRITE_ONLY)) in log.aborts
        return "wo" if is_unreadable else known if known in ("rw", "rww", "rwr") else "rw"
    return "ro" if (True, int(Code.READ_ONLY)) in log.aborts else known


def mapped_access(access: str, pdo: Pdo) -> str:
    """Return an access with which the object can be in this PDO."""
    if pdo.is_transmitted:
        return {"wo": "rw", "rww": "rw", "const": "ro"}.get(access, access)
    return {"ro": "rww", "const": "rww", "rwr": "rw"}.get(access, access)
