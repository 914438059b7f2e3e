"""Answers to questions about a bus with a model, in real and virtual time: `status`, and those about its faults."""

from typing import Any

from fieldrig.control.fault_questions import VERBS, answer_of_faults
from fieldrig.control.messages import Answer
from fieldrig.control.question_words import asked
from fieldrig.control.subject import Subject
from fieldrig.errors import ControlError


def answers_of_bus(bus: Subject) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        if verb == "status":
            return bus.statistics()
        if verb in VERBS:
            return answer_of_faults(bus, verb, message)
        raise ControlError(f"a bus cannot {asked(verb, message)}", f"it can: status, {', '.join(VERBS)}")

    return answer
