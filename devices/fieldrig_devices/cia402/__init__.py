"""CiA 402 (IEC 61800-7-201): power drive systems on an object dictionary."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "EDS",
]

if TYPE_CHECKING:
    from fieldrig_devices.cia402.single.own_objects import EDS
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.cia402.single.own_objects": "EDS",
        },
    )
