"""A device as a CANopen slave: objects of a CANopen node that show points of the device, and set them.

Source: CiA 301, CiA 401; which object shows which point is up to the device.  The node takes the points for the wires
of its signals.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.device import Point
from fieldrig.link import Link
from fieldrig.settings import ConfigFile, Settings
from fieldrig.storage.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.described import DescribedNode
from fieldrig_devices.canopen.emcy import Emcy
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings
from fieldrig_devices.canopen.shown_points import show_points

log = logging.getLogger(__name__)

Find = Callable[[str], Point | None]
"""Returns the point of a name, or None if there is none."""


class PointSlaveSettings(Settings):
    """Settings of the slave."""

    node_id: int = Field(ge=1, le=127, description="node-ID")
    eds: ConfigFile | None = Field(default=None, description="EDS file; null: that of fieldrig for all models")
    points: dict[str, str] | None = Field(
        default=None,
        description="points by object, '2000:01' or '6200:01.3' (bit 3); null: those of fieldrig's EDS; "
        "required with `eds`",
    )
    objects: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="power-on values that replace those of the EDS, such as '1017:00': 500"
    )

    def described(self, own: Path, default: Mapping[str, str]) -> DescribedNode:
        """Return the node for tools; `own` is the EDS of this kind of device, `default` the points of its objects."""
        return DescribedNode(self.node_id, self.eds or own, self.objects, self.points or default)

    def named(self, find: Find, default: Mapping[str, str]) -> dict[str, str]:
        """Return the points by object, and of the default ones only those that exist.  ValueError for unknown ones."""
        if self.points is None:
            return {key: name for key, name in default.items() if find(name) is not None}
        unknown = sorted(name for name in self.points.values() if find(name) is None)
        if unknown:
            raise ValueError(f"can_slave.points: expected points of the device, got {', '.join(unknown)}")
        return dict(self.points)


class PointWires:
    """The points as the wires of a node, by their names."""

    def __init__(self, find: Find) -> None:
        self._find = find
        self._handler: Callable[[Signal], None] = _ignore
        self._inputs: dict[str, Point] = {}
        self._shown: dict[str, bool | int | float] = {}

    def send(self, message: Signal) -> None:
        point = self._find(message.name)
        if point is None or point.write is None:
            return
        try:
            point.write(message.value)
        except ValueError as refused:
            log.debug("%s: %s", message.name, refused)

    def on_receive(self, handler: Callable[[Signal], None], interest: Sequence[object] | None = None) -> None:
        names = [str(name) for name in interest or ()]
        self._handler = handler
        self._inputs = {name: point for name in names if (point := self._find(name)) is not None}
        self._shown.clear()

    def sample(self) -> None:
        """Pass on all points that have changed since the last call."""
        for name in self._inputs:
            self.show(name)

    def show(self, name: str) -> None:
        """Pass on one point, if it has changed and an object shows it."""
        point = self._inputs.get(name)
        if point is None:
            return
        value = point.read()
        if not isinstance(value, str) and self._shown.get(name) != value:
            self._shown[name] = value
            self._handler(Signal(name, value))


def _ignore(_signal: Signal) -> None:
    """No node has started yet."""


class PointSlave:
    """The slave of one device."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        settings: PointSlaveSettings,
        store: Store,
        find: Find,
        eds: Path,
        default: Mapping[str, str],
        why_refused: Callable[[str], str] = lambda name: "",
    ) -> None:
        """`eds` and the `default` points by object serve settings without their own.

        `why_refused` says why the network may not set a point; an empty text if it may.

        ValueError for points that do not exist, and for objects that are not in the EDS.
        """
        self.wires = PointWires(find)
        signals: Mapping[str, str] = settings.named(find, default)
        node = CanopenSettings.model_validate(
            {
                "node_id": settings.node_id,
                "eds": str(settings.eds or eds),
                "signals": dict(signals),
                "objects": settings.objects,
            }
        )
        self._node = CanopenNode(clock, name, can, node, store, self.wires)
        show_points(self._node.dictionary, signals, find, why_refused)

    @property
    def emcy(self) -> Emcy:
        """The errors that the slave reports."""
        return self._node.emcy

    def start(self) -> None:
        self._node.start()
        self.wires.sample()

    def power_off(self) -> None:
        self._node.power_off()

    def points(self) -> Iterator[tuple[str, Point]]:
        """The objects of the node."""
        for key, point in self._node.points().items():
            yield f"can/{key}", point
