"""The needs of instances and functions under test: a part of the program that they belong to."""

from typing import Protocol

from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.types import Value


class Owner(Protocol):
    @property
    def cells(self) -> list[Value]: ...

    @property
    def now_ns(self) -> int: ...

    @property
    def runtime(self) -> Runtime: ...
