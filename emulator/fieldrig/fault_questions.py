"""Questions about the faults of a bus or a device, alike in real and virtual time.

faults        those that it has, by number
add_fault     {"fault": {"what": "drop", ...}}: one from now on; its number
clear_fault   {"number": 1}, or null for all: which ones were cleared
"""

from collections.abc import Mapping
from typing import Any, Final, Protocol

from fieldrig.asked import asked
from fieldrig.errors import ControlError

VERBS: Final = ("faults", "add_fault", "clear_fault")


class Faulty(Protocol):
    """Something with faults.  ControlError for a fault that it refuses, or that does not exist."""

    def add_fault(self, fault: Mapping[str, Any]) -> int: ...

    def clear_fault(self, number: int) -> None: ...

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...


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
    raise ControlError(f"can't {asked(verb, message)}", "expected a fault to add, or the number of one to clear")
