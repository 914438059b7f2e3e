"""A bus and a device of a rig file, checked."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from fieldrig.bus import Bus
from fieldrig.config.keys import OnExit
from fieldrig.config.yaml_source import NOWHERE, Mark
from fieldrig.device import Device
from fieldrig.settings import Settings


@dataclass(frozen=True)
class BusEntry:
    name: str
    kind: str
    bus: Bus[Any]
    process: str | None
    members: Mapping[str, str] = field(default_factory=dict)
    """Every device of the file that is linked to the bus, with its process, in the order of the file."""


@dataclass(frozen=True)
class DeviceEntry:
    name: str
    kind: str
    cls: type[Device]
    settings: Settings
    links: dict[str, tuple[str, ...]]
    """The names of the buses by parameter."""
    many: frozenset[str]
    """The parameters that take a list of buses."""
    process: str
    on_exit: OnExit
    after: tuple[str, ...]
    faults: tuple[Mapping[str, Any], ...] = ()
    """The faults from the start, apart from those in the settings of kinds that have a key of their own for them."""
    place: Mark = NOWHERE

    @property
    def buses(self) -> tuple[str, ...]:
        """Every bus that the device is linked to, once."""
        return tuple(dict.fromkeys(bus for buses in self.links.values() for bus in buses))
