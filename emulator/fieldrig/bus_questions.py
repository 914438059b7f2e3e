"""Questions about a bus that is run by a model, alike in real and virtual time: `status`, and about its faults."""

from typing import Any, Protocol

from fieldrig.control import Answer
from fieldrig.errors import ControlError
from fieldrig.fault_questions import VERBS, Faulty, answer_of_faults
from fieldrig.untrusted import shown


class Subject(Faulty, Protocol):
    """A bus."""

    def statistics(self) -> dict[str, float]: ...


def answers_of_bus(bus: Subject) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        if verb == "status":
            return bus.statistics()
        if verb in VERBS:
            return answer_of_faults(bus, verb, message)
        raise ControlError(f"a bus can't {verb} {shown(message)}", f"it can: status, {', '.join(VERBS)}")

    return answer
