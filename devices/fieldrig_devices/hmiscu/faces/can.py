"""The controller as a CiA 401 slave: objects of a CANopen node that show points, and set them.

Source: CiA 301, CiA 401; which object shows which point is ours (`objects.py`).  The node takes the points for the
wires of its signals.  Inputs are sampled at the end of each cycle of MAST; a write has its effect in the next one.
"""

import logging
from collections.abc import Callable, Iterator, Mapping, Sequence

from pydantic import Field

from fieldrig.clock import Clock
from fieldrig.device import Point
from fieldrig.link import Link
from fieldrig.settings import ConfigFile, Settings
from fieldrig.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.wires import Signal
from fieldrig_devices.canopen.node import CanopenNode, CanopenSettings
from fieldrig_devices.hmiscu.faces.objects import BITS, EDS, WORDS, pin_objects
from fieldrig_devices.registers.live_table import Lookup

log = logging.getLogger(__name__)


class CanFaceSettings(Settings):
    """Settings of the slave."""

    node_id: int = Field(ge=1, le=127, description="node-ID")
    eds: ConfigFile | None = Field(default=None, description="EDS file; null: that of fieldrig for all models")
    points: dict[str, str] | None = Field(
        default=None,
        description="points by object, '2000:01' or '6200:01.3' (bit 3); null: pins, terminals and counters; "
        "required with `eds`",
    )
    objects: dict[str, bool | int | float | str] = Field(
        default_factory=dict, description="power-on values that replace those of the EDS, such as '1017:00': 500"
    )

    def named(self, find: Lookup) -> dict[str, str]:
        """Return the points by object, and of the default ones only those that exist.  ValueError for unknown ones."""
        if self.points is None:
            return {key: name for key, name in default_points().items() if find(name) is not None}
        unknown = sorted(name for name in self.points.values() if find(name) is None)
        if unknown:
            raise ValueError(f"can_slave.points: expected points of the controller, got {', '.join(unknown)}")
        return dict(self.points)


def default_points() -> dict[str, str]:
    """Return the points of the objects in the EDS file of fieldrig."""
    bits = {f"{key}.{number}": name for key, names in BITS.items() for number, name in enumerate(names)}
    return bits | dict(WORDS) | pin_objects()


class PointWires:
    """The points as the wires of a node, by their names."""

    def __init__(self, find: Lookup) -> None:
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
        for name, point in self._inputs.items():
            value = point.read()
            if not isinstance(value, str) and self._shown.get(name) != value:
                self._shown[name] = value
                self._handler(Signal(name, value))


def _ignore(_signal: Signal) -> None:
    """No node has started yet."""


class CanFace:
    """The slave of one controller."""

    def __init__(
        self, clock: Clock, name: str, can: Link[CanFrame], settings: CanFaceSettings, store: Store, find: Lookup
    ) -> None:
        """ValueError for points that do not exist, and for objects that are not in the EDS."""
        self._wires = PointWires(find)
        self._node = CanopenNode(clock, name, can, _settings(settings, find), store, self._wires)

    def start(self) -> None:
        self._node.start()
        self._wires.sample()

    def power_off(self) -> None:
        self._node.power_off()

    def on_cycle(self) -> None:
        self._wires.sample()

    def points(self) -> Iterator[tuple[str, Point]]:
        """The objects of the node."""
        for key, point in self._node.points().items():
            yield f"can/{key}", point


def _settings(settings: CanFaceSettings, find: Lookup) -> CanopenSettings:
    signals: Mapping[str, str] = settings.named(find)
    return CanopenSettings.model_validate(
        {
            "node_id": settings.node_id,
            "eds": str(settings.eds or EDS),
            "signals": dict(signals),
            "objects": settings.objects,
        }
    )
