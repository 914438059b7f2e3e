"""A bus without a hub, such as a ring, whose faults may wait until a point or a wire has a value."""

from collections.abc import Mapping
from typing import Any

from fieldrig.control.subject import WaitingSubject
from fieldrig.faults.waiting import WaitingFaults


class Armed:
    def __init__(self, name: str, subject: WaitingSubject, waiting: WaitingFaults) -> None:
        """`name` is that of the bus."""
        self._name, self._subject, self._waiting = name, subject, waiting
        self.faults, self.begin_fault = subject.faults, subject.begin_fault
        self.statistics, self.conditions = subject.statistics, subject.conditions
        waiting.know(name, self)

    def add_fault(self, fault: Mapping[str, Any]) -> int:
        """Add a fault, and wait for its condition if it has one."""
        number = self._subject.add_fault(fault)
        self._waiting.arm(self._name, number)
        return number

    def clear_fault(self, number: int) -> None:
        self._waiting.forget(self._name, number)
        self._subject.clear_fault(number)
