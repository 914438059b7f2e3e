"""The MAx-4: the controller of a PacDrive system."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "EDS",
]

if TYPE_CHECKING:
    from fieldrig_devices.max4.can.objects import EDS
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.max4.can.objects": "EDS",
        },
    )
