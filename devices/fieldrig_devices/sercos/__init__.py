"""SERCOS: the protocol between a master and its drives on a fibre ring (IEC 61491)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "SercosMaster",
]

if TYPE_CHECKING:
    from fieldrig_devices.sercos.master import SercosMaster
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.sercos.master": "SercosMaster",
        },
    )
