"""The needs of instances and functions under test: a part of the program that they belong to."""

from collections.abc import Callable, Mapping
from typing import Any, Protocol

from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.types import BlockType, Value

Functions = Mapping[str, Mapping[str, Callable[..., Any]]]
"""Methods, by the key "", and the parts "GET" and "SET" of properties, by their names in small letters."""


class Owner(Protocol):
    @property
    def cells(self) -> list[Value]: ...

    @property
    def now_ns(self) -> int: ...

    @property
    def runtime(self) -> Runtime: ...

    def functions_at(self, kind: BlockType, address: int, name: str) -> Functions:
        """Return methods and properties of an instance; none if no part of it has this name."""
