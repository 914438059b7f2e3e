"""Answers to questions about a device, in real and virtual time.

They are about its points (`keys`, `get`, `set`), its front, its faults, and whatever else this kind of device
understands.
"""

from collections.abc import Callable, Iterable, Mapping
from typing import Any, Protocol

from fieldrig.control.fault_questions import VERBS, answer_of_faults
from fieldrig.control.messages import Answer
from fieldrig.control.question_words import asked
from fieldrig.control.subject import Faulty
from fieldrig.control.troubles import Troubles
from fieldrig.device import Device, Value
from fieldrig.errors import ControlError, refusals
from fieldrig.loop.real_clock import RealClock
from fieldrig.outside.untrusted import items, shown
from fieldrig.points.access import points_for, read_points, write_point
from fieldrig.points.facts import facts_of
from fieldrig.points.values import fitting


class Source(Faulty, Protocol):
    """A device with points.  `values` and `set` raise ControlError for an unknown key, or a value that is refused."""

    def facts(self) -> Mapping[str, Any]:
        """Return the unit and other facts of each point, by key."""

    def values(self, keys: Iterable[str] | None = None) -> Mapping[str, Value]:
        """Return the values of these points by key, all of one instant; None stands for all points."""

    def front(self) -> Mapping[str, Any]:
        """Return its front, in values that JSON has."""

    def set(self, key: str, value: Value) -> None: ...

    def answer(self, question: str, message: Any) -> Any:
        """Answer a question of this kind of device.  ControlError if the device refuses."""


class RealPoints:
    def __init__(self, name: str, device: Device, clock: RealClock, host_words: Callable[[], str]) -> None:
        """`host_words` returns how late the host was in the last seconds; "" if it was not."""
        self._name, self._device, self._clock = name, device, clock
        self._troubles = Troubles(name, device, host_words)

    def facts(self) -> Mapping[str, Any]:
        beside = self.look()
        facts = facts_of(self._device.points())
        return {key: fact | ({"host": beside[key]} if key in beside else {}) for key, fact in facts.items()}

    def front(self) -> Mapping[str, Any]:
        return self._clock.look(self._device.front_words)

    def look(self) -> Mapping[str, str]:
        """Look at the troubles of the device, and return the words about the host beside each, by key."""
        self._clock.look(self._troubles.look, self._clock.now_ns())
        return self._troubles.words()

    def values(self, keys: Iterable[str] | None = None) -> Mapping[str, Value]:
        return self._clock.look(lambda: read_points(self._name, points_for(self._device, keys or ()), keys))

    def set(self, key: str, value: Value) -> None:
        self._clock.handle(lambda: write_point(self._name, points_for(self._device, (key,)), key, value))

    def answer(self, question: str, message: Any) -> Any:
        answers: list[Any] = []
        with refusals(self._name):
            self._clock.handle(lambda: answers.append(self._device.answer(question, message)))
        return answers[0]

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        numbers: list[int] = []
        with refusals(self._name):
            self._clock.handle(lambda: numbers.append(self._device.add_fault(fault)))
        return numbers[0]

    def clear_fault(self, number: int) -> None:
        with refusals(self._name):
            self._clock.handle(self._device.clear_fault, number)

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        return self._clock.look(self._device.faults)


OWN = ("keys", "front", "get", "set")
"""Questions about the points of a device, which the device itself never sees."""
MOST_KEYS = 65_536
"""Most keys in one question."""


def _taken(key: str, value: Any, present: Value) -> Value:
    """Return the value in the point's type.

    ControlError for anything but a value, or for a text instead of a number.
    """
    if not isinstance(value, bool | int | float | str):
        raise ControlError(f"{key} cannot be {shown(value)}: expected a number, a text, true or false")
    if isinstance(value, str) and not isinstance(present, str):
        expected = "true or false" if isinstance(present, bool) else "a number"
        raise ControlError(f"{key} cannot be {shown(value)}: expected {expected}")
    return fitting(value, present)


def answers(source: Source) -> Answer:
    async def answer(verb: str, message: Any) -> Any:
        match verb, message:
            case "keys", _:
                return source.facts()
            case "front", None:
                return source.front()
            case "get", None:
                return source.values()
            case "get", {"keys": list(keys)}:
                return source.values(items(keys, str, MOST_KEYS, "keys"))
            case "set", {"values": dict(values)}:
                present = source.values(values)  # a name that is wrong is refused before anything is written
                taken = {key: _taken(key, value, present[key]) for key, value in values.items()}
                for key, value in taken.items():
                    source.set(key, value)
                return source.values(values)
        if verb in VERBS:
            return answer_of_faults(source, verb, message)
        if verb in OWN:
            raise ControlError(f"a device cannot {asked(verb, message)}", f"it can: {', '.join((*OWN, *VERBS))}")
        return source.answer(verb, message)

    return answer
