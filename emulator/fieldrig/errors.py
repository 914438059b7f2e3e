"""What can be wrong outside our own code, each with its remedy.

RigError              anything a user can mend; printed without a traceback
├── ConfigError       wrong configuration, with every mistake found
├── BusError          a port, a path, a network device that can't be had
└── ControlError      no rig answers, or it refuses
"""


class RigError(Exception):
    """Something outside our code is wrong; `remedy` says what to do next."""

    def __init__(self, what: str, remedy: str = "") -> None:
        super().__init__(f"{what}\n  {remedy}" if remedy else what)
        self.what = what
        self.remedy = remedy


class BusError(RigError):
    """A bus or one of its ports can't be opened."""


class ControlError(RigError):
    """No rig answers at the control endpoint, or it refuses what it was asked."""
