"""The ring of a PAM: frames between the axes manager and its nodes."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "Cycle",
    "Frames",
    "Reception",
    "Reports",
    "RingMessage",
]

if TYPE_CHECKING:
    from fieldrig_bus.ring.pam.message import Cycle, Frames, Reception, Reports, RingMessage
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_bus.ring.pam.message": "Cycle Frames Reception Reports RingMessage",
        },
    )
