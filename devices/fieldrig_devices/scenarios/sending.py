"""Messages that a scenario sends: CAN frames in the form of `cansend`, and bytes of serial lines."""

import re
from typing import Any, Final

from fieldrig.bus import Bus
from fieldrig.errors import ControlError
from fieldrig_bus.can.frame import CanFrame

_FRAME: Final = re.compile(r"([0-9A-Fa-f]{3}|[0-9A-Fa-f]{8})#(?:([Rr])([0-8]?)|((?:[0-9A-Fa-f]{2}\.?)*))")
FORM: Final = "expected a frame such as 000#0101 or 18FF0102#11.22 on a CAN bus, hex digits or 'text on a serial line"


def message_of(bus: Bus[Any], text: str) -> Any:
    """Return the message of a text.  ControlError for one that is none, and for a bus of another family."""
    try:
        if bus.family == "can":
            return _frame(text)
        if bus.family == "serial":
            return text[1:].encode("latin-1") if text.startswith("'") else _bytes(text)
    except ValueError as wrong:
        raise ControlError(f"{bus.name}: {text[:60]!r} cannot be sent: {wrong}", FORM) from wrong
    raise ControlError(f"{bus.name} is a bus of {bus.family}, on which a scenario sends nothing", FORM)


def _frame(text: str) -> CanFrame:
    found = _FRAME.fullmatch(text.strip())
    if found is None:
        raise ValueError("it is no frame")
    digits, is_remote, length, data = found[1], bool(found[2]), int(found[3] or 0), found[4] or ""
    content = bytes.fromhex(data.replace(".", ""))
    return CanFrame(int(digits, 16), content, len(digits) == 8, is_remote, length if is_remote else 0)


def _bytes(text: str) -> bytes:
    content = bytes.fromhex(text)
    if not content:
        raise ValueError("it is empty")
    return content
