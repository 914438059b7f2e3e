"""The exit codes of `fieldrig`, and of the processes of a rig, and the signal that ends a process at once."""

import signal
from enum import IntEnum
from typing import Final

KILL: Final[signal.Signals] = getattr(signal, "SIGKILL", signal.SIGTERM)
"""Ends a process at once.  On Windows SIGTERM does, which a process cannot handle there."""


class Exit(IntEnum):
    OK = 0
    BUG = 1
    DIFFERENT = 1  # as diff(1) and pytest have it
    TESTS_FAILED = 1
    WRONG = 2
    CANNOT_START = 3
    NO_RIG = 4
    DEVICE_FAILED = 5
    REFUSED = 6
    NOT_READY = 7
    NOT_CONFORMING = 8
    CRASHED = 70  # sysexits.h: EX_SOFTWARE


ABOUT = {
    Exit.OK: "success",
    Exit.BUG: (
        "internal error of fieldrig, with its traceback; of `fieldrig diff` and `replay`: there are differences;"
        " of `fieldrig iec test`: a test did not pass"
    ),
    Exit.WRONG: "wrong usage, or mistakes in a file",
    Exit.CANNOT_START: "cannot start: a port, a path or the control endpoint is not available",
    Exit.NO_RIG: "no rig answers at the control endpoint",
    Exit.DEVICE_FAILED: "a device failed, and its `on_exit` in the rig file is `stop`",
    Exit.REFUSED: "the rig or device refuses: unknown device or key, or a value that is not accepted",
    Exit.NOT_READY: (
        "not ready (`fieldrig status --ready`), or fewer lines than wanted in the given time (`fieldrig watch -n N"
        " --for DURATION`)"
    ),
    Exit.NOT_CONFORMING: "a node fails a conformance test (only `fieldrig conform`)",
    Exit.CRASHED: "a device's code failed (only processes of a rig)",
}
