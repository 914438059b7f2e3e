"""The controller as a CiA 401 slave: which object shows which point is ours (`objects.py`).

Inputs are sampled at the end of each cycle of MAST; a write has its effect in the next one.
"""

from collections.abc import Callable

from fieldrig.clock import Clock
from fieldrig.link import Link
from fieldrig.store import Store
from fieldrig_bus.can.frame import CanFrame
from fieldrig_devices.canopen.point_slave import Find, PointSlave, PointSlaveSettings
from fieldrig_devices.hmiscu.faces.objects import BITS, EDS, WORDS, pin_objects


def default_points() -> dict[str, str]:
    """Return the points of the objects in the EDS file of fieldrig."""
    bits = {f"{key}.{number}": name for key, names in BITS.items() for number, name in enumerate(names)}
    return bits | dict(WORDS) | pin_objects()


class CanFace(PointSlave):
    """The slave of one controller."""

    def __init__(
        self,
        clock: Clock,
        name: str,
        can: Link[CanFrame],
        settings: PointSlaveSettings,
        store: Store,
        find: Find,
        why_refused: Callable[[str], str],
    ) -> None:
        super().__init__(clock, name, can, settings, store, find, EDS, default_points(), why_refused)

    def on_cycle(self) -> None:
        self.wires.sample()
