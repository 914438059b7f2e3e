"""One device's end of a bus whose medium is outside the rig, with the faults of a model of that bus.

What the device sends goes through the model, in which everything outside is one further member that hears all.
"""

from collections.abc import Callable, Mapping
from random import Random
from typing import Any, Final, Generic, TypeVar

from fieldrig.bus import BusModel, Delivery
from fieldrig.clock import Alarm, Clock
from fieldrig.faults.disturbed import Disturbed, Effects

M = TypeVar("M")

OTHERS: Final = "fieldrig:others"
"""Everything outside; no device has a colon in its name."""


class DisturbedEnd(Generic[M]):
    """The way out of an end, and the faults on it (`control.end_questions`)."""

    def __init__(
        self,
        clock: Clock,
        member: str,
        model: BusModel[M],
        effects: Effects[M],
        seed: str,
        pass_on: Callable[[Delivery[Any]], None],
    ) -> None:
        """`pass_on` is called with what leaves the model: messages to everything outside, and the notes of faults."""
        self._clock, self._member, self._pass_on = clock, member, pass_on
        self._alarm = Alarm(clock)
        self._model = Disturbed(model, effects)
        self._model.begin(clock.now_ns(), Random(seed))
        self._model.join(member)
        self._model.join(OTHERS)
        self._model.listen(clock.now_ns(), OTHERS, None)
        self.carry()

    def send(self, message: M) -> None:
        self._model.submit(self._clock.now_ns(), self._member, message)
        self.carry()

    def switch(self, is_on: bool) -> None:
        """Tell the model that the device has no power, or has it again."""
        if is_on:
            self._model.join(self._member)
        else:
            self._model.power_lost(self._clock.now_ns(), self._member)
        self.carry()

    def close(self) -> None:
        self._alarm.stop()

    @property
    def given(self) -> int:
        """The highest number of a fault so far."""
        return self._model.given

    def add_fault(self, fault: Mapping[str, Any], number: int | None = None) -> int:
        """Add a fault whose values may be texts, and return its number.  ValueError for one that cannot be."""
        number = self._model.add_fault(self._clock.now_ns(), fault, number)
        self.carry()
        return number

    def begin(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""
        self._model.begin_fault(self._clock.now_ns(), number)
        self.carry()

    def clear_fault(self, number: int) -> None:
        """Remove a fault.  ValueError if there is none with this number."""
        self._model.clear_fault(self._clock.now_ns(), number)
        self.carry()

    def faults(self) -> Mapping[int, Mapping[str, Any]]:
        """Return the faults that were added and not cleared, by number."""
        return self._model.all_faults(self._clock.now_ns())

    def carry(self) -> None:
        """Pass on everything that is due, and set a timer for the rest."""
        next_ns = self._model.next_ns()
        while next_ns is not None and next_ns <= (now_ns := self._clock.now_ns()):
            for delivery in self._model.collect(now_ns):
                self._pass_on(delivery)
            next_ns = self._model.next_ns()
        self._alarm.at(next_ns, self.carry)
