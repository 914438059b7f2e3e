"""A motion command: its inputs, as they were at the edge of Execute, and what has become of it."""

from enum import Enum, auto
from typing import NamedTuple

from fieldrig_devices.hmiscu.enumerations import Direction, ErrorId
from fieldrig_devices.hmiscu.pto.matrix import Next


class Status(Enum):
    BUSY = auto()
    REACHED = auto()
    """Done, or the velocity is reached."""
    ABORTED = auto()
    ERROR = auto()


class Order(NamedTuple):
    """The inputs of a motion block.  A block without one of the pins leaves it at 0."""

    kind: Next
    velocity: int = 0
    distance: int = 0
    acceleration: int = 0
    deceleration: int = 0
    direction: int = Direction.PTO_POSITIVE


class Command:
    """One execution of a motion block.  The channel changes its status, and the block shows it."""

    def __init__(self, order: Order) -> None:
        self.order = order
        self.status = Status.BUSY
        self.error = ErrorId.NO_ERROR
        self.is_active = False
        """True while the command controls the axis."""
        self.is_held = True
        """The level of Execute.  A PTOStop holds the axis at rest with it."""

    def end(self, status: Status, error: ErrorId = ErrorId.NO_ERROR) -> None:
        self.status, self.error = status, error
        self.is_active = False
