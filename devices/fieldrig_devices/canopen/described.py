"""The CANopen nodes that a device is, with the EDS that describes each: for tools that test or read them.

A device with an EDS of its own, or with several nodes, says so by the method `canopen_nodes` of its settings.  The
settings of `canopen.node` are such a node themselves.
"""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Final, NamedTuple, Protocol, runtime_checkable

from fieldrig_devices.canopen.signals import SignalSettings

Signals = Mapping[str, str | SignalSettings]
NO_SIGNALS: Final[Signals] = {}


class DescribedNode(NamedTuple):
    """One node: its node-ID, its EDS file, and the power-on values of the rig file that replace those of the EDS."""

    node_id: int | None
    eds: Path
    objects: Mapping[str, bool | int | float | str]
    signals: Signals = NO_SIGNALS
    """The wires or points that objects and bits show, by object and bit."""


@runtime_checkable
class HasNodes(Protocol):
    """The settings of a device that is any number of CANopen nodes."""

    def canopen_nodes(self) -> Iterator[DescribedNode]:
        """Yield the nodes of the device."""


@runtime_checkable
class IsNode(Protocol):
    """The settings of a device that is one CANopen node."""

    @property
    def node_id(self) -> int | None: ...

    @property
    def eds(self) -> Path: ...

    @property
    def objects(self) -> Mapping[str, bool | int | float | str]: ...


@runtime_checkable
class HasSignals(Protocol):
    """The settings of a node whose objects are connected to wires."""

    @property
    def signals(self) -> Signals: ...


def nodes_of(settings: object) -> Iterator[DescribedNode]:
    """Yield the nodes of the device with these settings; none if it is no CANopen node."""
    if isinstance(settings, HasNodes):
        yield from settings.canopen_nodes()
    elif isinstance(settings, IsNode):
        signals = settings.signals if isinstance(settings, HasSignals) else NO_SIGNALS
        yield DescribedNode(settings.node_id, settings.eds, settings.objects, signals)
