"""Questions about one device's own end of a bus whose medium is not the rig's: the faults that it has.

    end/<bus>/<device>/faults        those that it has, by number
    end/<bus>/<device>/given         the highest number so far
    end/<bus>/<device>/add_fault     {"fault": {"what": "drop", ...}, "number": 3}
    end/<bus>/<device>/clear_fault   {"number": 3}

A fault of such a bus is given to every end under one number, which the asker chooses; `fieldrig fault` does so.
"""

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable

from fieldrig.control.messages import Answer
from fieldrig.control.question_words import asked
from fieldrig.errors import ControlError, refusals
from fieldrig.faults.waiting import WaitingFaults
from fieldrig.loop.real_clock import RealClock


class FaultsOfEnd(Protocol):
    """The faults of an end.  ValueError for one that it refuses, or that does not exist."""

    @property
    def given(self) -> int:
        """The highest number so far."""

    def add_fault(self, fault: Mapping[str, Any], number: int | None = None) -> int: ...

    def begin(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""

    def clear_fault(self, number: int) -> None: ...

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...


@runtime_checkable
class FaultyEnd(Protocol):
    """A link that takes faults."""

    @property
    def injected(self) -> FaultsOfEnd: ...


@runtime_checkable
class TellingEnd(Protocol):
    """A link that reports states to a person."""

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        """Return the states that are present: a text for each, by name (`BusModel.conditions`)."""


class FaultsOfOneEnd:
    """The faults of one end, of which some may wait until a point of its process has a value."""

    def __init__(self, name: str, faults: FaultsOfEnd, waiting: WaitingFaults) -> None:
        """`name` is that of the end among the parts of the process."""
        self._name, self._faults, self._waiting = name, faults, waiting
        self.faults, self.begin_fault = faults.faults, faults.begin
        waiting.know(name, self)

    @property
    def given(self) -> int:
        """The highest number so far."""
        return self._faults.given

    def add_fault(self, fault: Mapping[str, Any], number: int) -> None:
        self._faults.add_fault(fault, number)
        self._waiting.arm(self._name, number)

    def clear_fault(self, number: int) -> None:
        self._waiting.forget(self._name, number)
        self._faults.clear_fault(number)


def answers_of_end(bus: str, end: FaultsOfOneEnd, clock: RealClock) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        with refusals(bus):
            match verb, message:
                case "faults", _:
                    return end.faults()
                case "given", _:
                    return end.given
                case "add_fault", {"fault": dict(fault), "number": int(number)}:
                    return clock.handle(end.add_fault, fault, number)
                case "clear_fault", {"number": int(number)}:
                    return clock.handle(end.clear_fault, number)
        raise ControlError(f"an end cannot {asked(verb, message)}", "it can: faults, given, add_fault, clear_fault")

    return answer
