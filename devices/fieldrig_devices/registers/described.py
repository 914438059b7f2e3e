"""The register tables that a device serves, for tools that name its registers.

A device says so by the method `register_tables` of its settings.
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
