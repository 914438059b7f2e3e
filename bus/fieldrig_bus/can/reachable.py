"""The optional ability of a CAN bus to be joined from outside with python-can."""

from typing import Protocol, runtime_checkable


@runtime_checkable
class PythonCanBus(Protocol):
    """A bus that programs outside the rig may be able to join with python-can."""

    def python_can(self) -> dict[str, object] | None:
        """Arguments of `can.Bus(...)` to join from outside; None where that is not possible."""


def python_can_of(bus: object) -> dict[str, object] | None:
    """Arguments of `can.Bus(...)` to join this bus from outside; None for a bus that cannot be joined so."""
    return bus.python_can() if isinstance(bus, PythonCanBus) else None
