"""What a CiA 402 axis moves: a drive with its motor, as whoever has one shows it.  Lengths are encoder increments."""

from collections.abc import Callable
from enum import Enum, IntEnum, auto
from typing import Protocol

from fieldrig_devices.motion.travel import NEGATIVE, POSITIVE


class Kind(Enum):
    """What a set value is."""

    POSITION = auto()
    """Increments."""
    VELOCITY = auto()
    """Increments per second."""
    TORQUE = auto()
    """0.1 % of the motor's rated torque."""


class Switch(IntEnum):
    """Bits of 60FDh."""

    NEGATIVE_LIMIT = NEGATIVE
    POSITIVE_LIMIT = POSITIVE
    HOME = 0x4


class Motor(Protocol):
    @property
    def kinds(self) -> frozenset[Kind]:
        """Which set values it can follow."""

    @property
    def is_there(self) -> bool: ...

    @property
    def is_ready(self) -> bool:
        """Power is there, and nothing hinders enabling."""

    @property
    def is_following(self) -> bool: ...

    @property
    def is_stopping(self) -> bool:
        """By itself; it follows nothing."""

    @property
    def error(self) -> int:
        """An error code as in 603Fh; 0: none."""

    @property
    def has_warning(self) -> bool: ...

    @property
    def position(self) -> int: ...

    @property
    def velocity(self) -> float: ...

    @property
    def torque(self) -> int: ...

    @property
    def rated_torque_mnm(self) -> int: ...

    @property
    def revolution(self) -> int:
        """Increments from one zero of the encoder to the next."""

    @property
    def inputs(self) -> int:
        """As in 60FDh: those of `Switch`, from bit 16 on others."""

    def enable(self, is_on: bool) -> None: ...

    def limit_torque(self, most: int) -> None:
        """In whatever it does, from when it knows it; 0.1 % of its rated torque."""

    def set_outputs(self, outputs: int, mask: int) -> None:
        """Bits from 16 on, as in 60FEh."""

    def reset(self, done: Callable[[], None]) -> None:
        """Quit what is wrong."""


def passed_zero(before: int, now: int, revolution: int) -> int | None:
    """The last zero of the encoder on the way, if there was one."""
    if now > before:
        zero = now // revolution * revolution
        return zero if zero > before else None
    zero = -(-now // revolution) * revolution
    return zero if zero < before else None
