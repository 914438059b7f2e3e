"""The command matrix: what becomes of a command that comes while another one runs (SCU-053, manual 1113 to 1125)."""

from enum import Enum, auto
from typing import Final


class Running(Enum):
    """The rows: the command that the axis carries out, and its phase."""

    MOVE_RELATIVE = auto()
    VELOCITY_CONSTANT = auto()
    VELOCITY_RAMPING = auto()
    STOP_DECELERATING = auto()


class Next(Enum):
    """The columns."""

    MOVE_RELATIVE = auto()
    MOVE_VELOCITY = auto()
    STOP = auto()


class Outcome(Enum):
    COMMAND_ABORTED = auto()
    """Both commands end, and the axis makes a fast stop."""
    IMMEDIATE_ACCEPT = auto()
    NEW_VELOCITY = auto()
    AXIS_ERROR = auto()
    """Both commands end with PTO_AXIS_ERROR, and the axis makes a fast stop."""


_ROWS: Final = {
    Running.MOVE_RELATIVE: (Outcome.COMMAND_ABORTED, Outcome.COMMAND_ABORTED, Outcome.IMMEDIATE_ACCEPT),
    Running.VELOCITY_CONSTANT: (Outcome.COMMAND_ABORTED, Outcome.NEW_VELOCITY, Outcome.IMMEDIATE_ACCEPT),
    Running.VELOCITY_RAMPING: (Outcome.COMMAND_ABORTED, Outcome.COMMAND_ABORTED, Outcome.IMMEDIATE_ACCEPT),
    Running.STOP_DECELERATING: (Outcome.AXIS_ERROR, Outcome.AXIS_ERROR, Outcome.AXIS_ERROR),
}

MATRIX: Final = {
    (running, command): outcome
    for running, outcomes in _ROWS.items()
    for command, outcome in zip(Next, outcomes, strict=True)
}
