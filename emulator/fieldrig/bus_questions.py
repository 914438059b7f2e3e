"""Questions about a bus that is run by a model, alike in real and virtual time.

status        counters
faults        those that it has, by number
add_fault     {"fault": {"what": "drop", ...}}: one from now on; its number
clear_fault   {"number": 1}, or null for all: which ones were cleared
"""

from collections.abc import Mapping
from typing import Any, Protocol

from fieldrig.control import Answer
from fieldrig.errors import ControlError


class Subject(Protocol):
    """A bus.  ControlError for a fault that it can't take, or that isn't there."""

    def statistics(self) -> dict[str, float]: ...

    def add_fault(self, fault: Mapping[str, Any]) -> int: ...

    def clear_fault(self, number: int) -> None: ...

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...


def answers_of_bus(bus: Subject) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        match verb, message:
            case "status", _:
                return bus.statistics()
            case "faults", _:
                return bus.faults()
            case "add_fault", {"fault": dict(fault)}:
                return {"number": bus.add_fault(fault)}
            case "clear_fault", {"number": int() | None as number}:
                numbers = list(bus.faults()) if number is None else [number]
                for one in numbers:
                    bus.clear_fault(one)
                return {"cleared": numbers}
        raise ControlError(f"a bus can't {verb} {message!r}", "it can: status, faults, add_fault, clear_fault")

    return answer
