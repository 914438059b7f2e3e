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
from fieldrig.faults.injected import InjectedFaults
from fieldrig.loop.real_clock import RealClock


@runtime_checkable
class FaultyEnd(Protocol):
    """A link that takes faults."""

    @property
    def injected(self) -> InjectedFaults[Any]: ...


@runtime_checkable
class TellingEnd(Protocol):
    """A link that reports states to a person."""

    def conditions(self, now_ns: int) -> Mapping[str, str]:
        """Return the states that are present: a text for each, by name (`BusModel.conditions`)."""


def answers_of_end(bus: str, end: FaultyEnd, clock: RealClock) -> Answer:
    faults = end.injected

    def add(fault: Mapping[str, Any], number: int) -> None:
        faults.add_fault(fault, number)

    async def answer(verb: str, message: Any) -> Any:
        with refusals(bus):
            match verb, message:
                case "faults", _:
                    return faults.faults()
                case "given", _:
                    return faults.given
                case "add_fault", {"fault": dict(fault), "number": int(number)}:
                    return clock.handle(add, fault, number)
                case "clear_fault", {"number": int(number)}:
                    return clock.handle(faults.clear_fault, number)
        raise ControlError(f"an end cannot {asked(verb, message)}", "it can: faults, given, add_fault, clear_fault")

    return answer
