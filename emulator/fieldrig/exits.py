"""The exit codes of `fieldrig`, and of the processes of a rig."""

from enum import IntEnum


class Exit(IntEnum):
    OK = 0
    BUG = 1
    WRONG = 2
    CANNOT_START = 3
    NO_RIG = 4
    DEVICE_FAILED = 5
    REFUSED = 6
    NOT_READY = 7
    NOT_CONFORMING = 8
    CRASHED = 70  # sysexits.h: EX_SOFTWARE


ABOUT = {
    Exit.OK: "done",
    Exit.BUG: "a fault of fieldrig's own, with its traceback",
    Exit.WRONG: "wrong usage, or mistakes in the rig file",
    Exit.CANNOT_START: "can't start: a port, a path or the control endpoint is taken",
    Exit.NO_RIG: "no rig answers at the control endpoint",
    Exit.DEVICE_FAILED: "a device failed, and the rig file says that the rig stops then",
    Exit.REFUSED: "the rig refuses: no such device or key, or a value that it can't take",
    Exit.NOT_READY: "not ready (only `fieldrig status --ready`)",
    Exit.NOT_CONFORMING: "a node fails a case of a standard's test (only `fieldrig conform`)",
    Exit.CRASHED: "a device's own code failed (only of the processes of a rig)",
}
