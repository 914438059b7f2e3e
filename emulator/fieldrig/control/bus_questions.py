"""Answers to questions about a bus with a model, in real and virtual time.

They are `status`, `conditions` (the states that are reported to a person), `keys` (its signals), and those about its
faults.
"""

from typing import Any

from fieldrig.control.fault_questions import VERBS, answer_of_faults
from fieldrig.control.messages import Answer
from fieldrig.control.question_words import asked
from fieldrig.control.subject import SignalSubject, Subject
from fieldrig.errors import ControlError


def answers_of_bus(bus: Subject) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        if verb == "status":
            return bus.statistics()
        if verb == "conditions":
            return dict(bus.conditions())
        if verb == "keys":
            return dict(bus.signals()) if isinstance(bus, SignalSubject) else {}
        if verb in VERBS:
            return answer_of_faults(bus, verb, message)
        remedy = f"it can: status, conditions, keys, {', '.join(VERBS)}"
        raise ControlError(f"a bus cannot {asked(verb, message)}", remedy)

    return answer
