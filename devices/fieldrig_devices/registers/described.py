"""The registers that a device serves, for tools that name them.

A device says so by the method `register_tables` of its settings if it has a table, or by `register_names` if the names
are those of its program.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple, Protocol, runtime_checkable


class DescribedUnit(NamedTuple):
    """One unit, and the file of its table."""

    unit_id: int
    table: Path


@runtime_checkable
class HasTables(Protocol):
    """The settings of a device with register tables."""

    def register_tables(self) -> Iterator[DescribedUnit]:
        """Yield the units of the device with their tables."""


class RegisterNames(Protocol):
    """The registers and bits of one unit; `space` is a key of `SPACES`."""

    def names(self, space: str, address: int, count: int) -> str:
        """Return the names of `count` registers or bits from `address` on."""

    def registers(self, space: str, address: int, data: bytes) -> str:
        """Return names and values of registers whose bytes are `data`."""

    def bits(self, space: str, address: int, count: int, data: bytes) -> str:
        """Return names and values of `count` bits, the lowest one of the first byte first."""


class NamedUnit(NamedTuple):
    """One unit, and the names of its registers."""

    unit_id: int
    names: RegisterNames


@runtime_checkable
class HasRegisterNames(Protocol):
    """The settings of a device whose program names its registers."""

    def register_names(self) -> Iterator[NamedUnit]:
        """Yield the units of the device; none if the program has mistakes."""
