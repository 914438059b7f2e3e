"""Logs compared with each other, and played back to a rig (`fieldrig diff`, `fieldrig replay`)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "DiffResult",
    "DiffRow",
    "FirstDifference",
    "diff",
]

if TYPE_CHECKING:
    from fieldrig_devices.replay.calls import diff
    from fieldrig_devices.replay.diff_result import DiffResult, DiffRow, FirstDifference
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.replay.calls": "diff",
            "fieldrig_devices.replay.diff_result": "DiffResult DiffRow FirstDifference",
        },
    )
