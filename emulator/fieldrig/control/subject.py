"""The parts of a rig that answer questions about faults and about a bus: protocols, as `bus.py` knows them too."""

from collections.abc import Mapping
from typing import Any, Protocol, runtime_checkable


class Faulty(Protocol):
    """Something with faults.  ControlError for a fault that it refuses, or that does not exist."""

    def add_fault(self, fault: Mapping[str, Any]) -> int: ...

    def clear_fault(self, number: int) -> None: ...

    def faults(self) -> Mapping[int, Mapping[str, Any]]: ...


class Subject(Faulty, Protocol):
    """A bus that can be asked for its statistics and its faults."""

    def statistics(self) -> dict[str, float]: ...

    def conditions(self) -> Mapping[str, str]:
        """Return the states that are reported to a person (`BusModel.conditions`)."""


class WaitingSubject(Subject, Protocol):
    """A bus without a hub, whose faults may wait for a condition; those of a rig in virtual time are the rig's."""

    def begin_fault(self, number: int) -> None:
        """Begin a fault that waits for its condition, which is met now."""


@runtime_checkable
class SignalSubject(Protocol):
    """A bus whose messages carry signals, such as wires."""

    def signals(self) -> Mapping[str, Mapping[str, Any]]:
        """Return the facts of each signal, by its name."""
