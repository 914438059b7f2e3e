"""The SERCOS ring (IEC 61491)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Answers",
    "Cycle",
    "Mdt",
    "Mst",
    "RingMessage",
]

if TYPE_CHECKING:
    from fieldrig_bus.ring.sercos.message import Answers, Cycle, Mdt, Mst, RingMessage
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.ring.sercos.message": "Answers Cycle Mdt Mst RingMessage",
        },
    )
