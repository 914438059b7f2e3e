"""The screws of the node: where a variable meets the machine."""

from collections.abc import Callable, Mapping
from typing import Protocol

from fieldrig_devices.canopen.datatypes import Value
from fieldrig_devices.canopen.variable import Variable


class Terminal(Protocol):
    """What an output carries, or an input feels.  A plain variable is its own terminal."""

    watchers: list[Callable[[], None]]
    """Called after each change of `value`."""

    @property
    def value(self) -> Value: ...

    def put(self, value: Value) -> None:
        """Feel `value` from the machine."""


Terminals = Mapping[Variable, Terminal]
"""Those of variables that a profile stands before."""
