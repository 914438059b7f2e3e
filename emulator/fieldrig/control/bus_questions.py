"""Answers to questions about a bus with a model, in real and virtual time: `status`, and those about its faults."""

from collections.abc import Mapping
from typing import Any, Protocol

from fieldrig.control.fault_questions import VERBS, Faulty, answer_of_faults
from fieldrig.control.messages import Answer
from fieldrig.control.question_words import asked
from fieldrig.errors import ControlError


class Subject(Faulty, Protocol):
    """A bus that can be asked for its statistics and its faults."""

    def statistics(self) -> dict[str, float]: ...

    def conditions(self) -> Mapping[str, str]:
        """Return the states that are reported to a person (`BusModel.conditions`)."""


def answers_of_bus(bus: Subject) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        if verb == "status":
            return bus.statistics()
        if verb in VERBS:
            return answer_of_faults(bus, verb, message)
        raise ControlError(f"a bus cannot {asked(verb, message)}", f"it can: status, {', '.join(VERBS)}")

    return answer
