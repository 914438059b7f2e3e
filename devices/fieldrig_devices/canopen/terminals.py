"""The node's I/O terminals: the boundary between a variable and the machine."""

from collections.abc import Callable, Mapping
from typing import Protocol

from fieldrig_devices.canopen.datatypes import Value
from fieldrig_devices.canopen.variable import Variable


class Terminal(Protocol):
    """The state of an output or input.  A variable without a profile is its own terminal."""

    watchers: list[Callable[[], None]]
    """Called after each change of `value`."""

    @property
    def value(self) -> Value: ...

    def put(self, value: Value) -> None:
        """Take `value` from the machine."""


Terminals = Mapping[Variable, Terminal]
"""Terminals of the variables that a profile processes."""
