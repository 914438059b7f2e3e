"""Questions about the faults of a bus or a device, alike in real and virtual time.

faults        those that it has, by number
add_fault     {"fault": {"what": "drop", ...}}: one from now on; its number
clear_fault   {"number": 1}, or null for all: which ones were cleared
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final

from fieldrig.control.question_words import asked
from fieldrig.control.subject import Faulty
from fieldrig.errors import ControlError
from fieldrig.points.values import show_number

VERBS: Final = ("faults", "add_fault", "clear_fault")


TIMES: Final = ("when", "start_ms", "duration_ms")
STATE: Final = ("state", "applied", "left_ms")
STANDING: Final = ("what", *STATE)
"""The keys of a fault that `fieldrig fault` shows in columns of their own."""
IN_HEX: Final = ("identifier", "mask")


def in_words(fault: Mapping[str, Any], without: Sequence[str] = STATE) -> str:
    """Return the fault in the words of the command line, such as `drop identifier=0x185`."""
    name = [str(fault["what"])] if "what" in fault and "what" not in without else []
    keys = [f"{key}={_text(key, value)}" for key, value in fault.items() if key not in ("what", *without)]
    return " ".join([*name, *keys])


def _text(key: str, value: Any) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return f"[{', '.join(map(str, value))}]"
    if isinstance(value, float):
        return show_number(value)
    return f"{value:#x}" if key in IN_HEX and isinstance(value, int) else str(value)


def answer_of_faults(subject: Faulty, verb: str, message: Any) -> Any:
    match verb, message:
        case "faults", _:
            return subject.faults()
        case "add_fault", {"fault": dict(fault)}:
            return {"number": subject.add_fault(fault)}
        case "clear_fault", {"number": int() | None as number}:
            numbers = list(subject.faults()) if number is None else [number]
            for number in numbers:
                subject.clear_fault(number)
            return {"cleared": numbers}
    raise ControlError(f"cannot {asked(verb, message)}", "expected a fault to add, or the number of one to clear")
