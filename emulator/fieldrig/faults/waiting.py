"""The faults of a process in real time that wait until a point has a value.

A process reads the points of its own devices; those of others are waited for in their processes.
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


class Elsewhere(Protocol):
    """The conditions on devices of other processes."""

    def add(self, name: str, fault: int, device: str, text: str) -> None:
        """Wait for the condition of a fault."""

    def forget(self, name: str, fault: int) -> None: ...


class OwnPoints(Points, Protocol):
    def has(self, device: str) -> bool:
        """Return whether a device is one of this process."""


class WaitingFaults:
    """Begins the faults of the parts of a process when their conditions are met."""

    def __init__(
        self, clock: Clock, points: OwnPoints, tell: Callable[[], None], elsewhere: Elsewhere | None = None
    ) -> None:
        """`tell` tells the changes of the points since the last call."""
        self._clock, self._points, self._elsewhere = clock, points, elsewhere
        self._parts: dict[str, Part] = {}
        self._triggers = Triggers(clock, points, self.begin, tell=tell)

    def know(self, name: str, part: Part) -> None:
        """Know a part from now on, by a name of its own in this process."""
        self._parts[name] = part

    def arm_all(self) -> None:
        """Wait for the conditions of faults from the start.  RigError for one that cannot be met.

        A device may have more points later, such as the variables of a program that is still compiled.
        """
        for name, part in self._parts.items():
            for number, fault in part.faults().items():
                when = fault.get("when")
                if isinstance(when, str):
                    try:
                        self._await(name, number, when)
                    except ControlError as cause:
                        if self._elsewhere is None:
                            raise RigError(f"{name}: fault {number}: {cause.what}", cause.remedy) from cause
                        self._elsewhere.add(name, number, condition_of(when).device, when)

    def arm(self, name: str, number: int) -> None:
        """Wait for the condition of a fault, if it has one.  ControlError, without the fault, if it cannot be met."""
        when = self._parts[name].faults()[number].get("when")
        if isinstance(when, str):
            try:
                self._await(name, number, when)
            except ControlError:
                self._parts[name].clear_fault(number)
                raise

    def forget(self, name: str, number: int) -> None:
        """Wait no longer for the condition of a fault, if it waits for one."""
        self._triggers.forget(name, number)
        if self._elsewhere is not None:
            self._elsewhere.forget(name, number)

    def _await(self, name: str, number: int, when: str) -> None:
        condition = condition_of(when)
        if self._elsewhere is not None and not self._points.has(condition.device):
            self._elsewhere.add(name, number, condition.device, when)
        else:
            self._triggers.add(self._clock.now_ns(), name, number, condition)

    def begin(self, name: str, number: int) -> None:
        """Begin a fault, as its condition is met."""
        self._parts[name].begin_fault(number)
