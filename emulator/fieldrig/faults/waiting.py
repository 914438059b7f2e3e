"""The faults of a process in real time that wait until a point has a value.

A process reads the points of its own devices only, so the condition of a fault is one of these.
"""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from fieldrig.clock import Clock
from fieldrig.errors import ControlError, RigError
from fieldrig.faults.condition import condition_of
from fieldrig.faults.triggers import Points, Triggers


class Part(Protocol):
    """A bus, an end of one, or a device: something with faults."""

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""

    def clear_fault(self, number: int) -> None: ...


class WaitingFaults:
    """Begins the faults of the parts of a process when their conditions are met."""

    def __init__(self, clock: Clock, points: Points, tell: Callable[[], None]) -> None:
        """`tell` tells the changes of the points since the last call."""
        self._clock = clock
        self._parts: dict[str, Part] = {}
        self._triggers = Triggers(clock, points, self._begin, tell=tell)

    def know(self, name: str, part: Part) -> None:
        """Know a part from now on, by a name of its own in this process."""
        self._parts[name] = part

    def arm_all(self) -> None:
        """Wait for the conditions of faults from the start.  RigError for one that cannot be met."""
        for name, part in self._parts.items():
            for number in part.faults():
                try:
                    self.arm(name, number)
                except ControlError as cause:
                    raise RigError(f"{name}: fault {number}: {cause.what}", cause.remedy) from cause

    def arm(self, name: str, number: int) -> None:
        """Wait for the condition of a fault, if it has one.  ControlError, without the fault, if it cannot be met."""
        when = self._parts[name].faults()[number].get("when")
        if isinstance(when, str):
            try:
                self._triggers.add(self._clock.now_ns(), name, number, condition_of(when))
            except ControlError:
                self._parts[name].clear_fault(number)
                raise

    def forget(self, name: str, number: int) -> None:
        """Wait no longer for the condition of a fault, if it waits for one."""
        self._triggers.forget(name, number)

    def _begin(self, name: str, number: int) -> None:
        self._parts[name].begin_fault(number)
