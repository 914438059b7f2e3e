"""Logs compared with each other, and played back to a rig (`fieldrig diff`, `fieldrig replay`)."""

from typing import TYPE_CHECKING

from fieldrig.lazy import lazy_names

__all__ = [
    "DiffResult",
    "DiffRow",
    "Difference",
    "FirstDifference",
    "ReplayResult",
    "diff",
    "replay",
]

if TYPE_CHECKING:
    from fieldrig_devices.replay.calls import diff, replay
    from fieldrig_devices.replay.diff_result import DiffResult, DiffRow, FirstDifference
    from fieldrig_devices.replay.replay_result import Difference, ReplayResult
else:
    __getattr__, __dir__ = lazy_names(
        __name__,
        {
            "fieldrig_devices.replay.calls": "diff replay",
            "fieldrig_devices.replay.diff_result": "DiffResult DiffRow FirstDifference",
            "fieldrig_devices.replay.replay_result": "Difference ReplayResult",
        },
    )
