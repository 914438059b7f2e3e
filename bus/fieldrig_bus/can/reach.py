"""Buses that a program outside the rig can open with python-can."""

from collections.abc import Mapping
from typing import Protocol, runtime_checkable


@runtime_checkable
class PythonCanReach(Protocol):
    """A CAN bus that python-can may reach."""

    def python_can(self) -> Mapping[str, object] | None:
        """Return the arguments of `can.Bus` that open this bus; None if its settings have no way in."""
