"""The ring of a PAM: what the PAM and its ST1 and Smart-IO nodes tell each other (sections 3.1 to 3.5)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "AxisItem",
    "AxisOrder",
    "DeclaredNode",
    "Move",
    "NodeType",
    "RingLimits",
    "RingMaster",
]

if TYPE_CHECKING:
    from fieldrig_devices.pamring.declared import DeclaredNode
    from fieldrig_devices.pamring.frames import AxisItem, AxisOrder, Move, NodeType
    from fieldrig_devices.pamring.master import RingMaster
    from fieldrig_devices.pamring.settings import RingLimits
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.pamring.declared": "DeclaredNode",
            "fieldrig_devices.pamring.frames": "AxisItem AxisOrder Move NodeType",
            "fieldrig_devices.pamring.master": "RingMaster",
            "fieldrig_devices.pamring.settings": "RingLimits",
        },
    )
