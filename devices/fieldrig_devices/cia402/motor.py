"""The motor that a CiA 402 axis moves, as its owner presents it.  Lengths are encoder increments."""

from collections.abc import Callable
from enum import Enum, IntEnum, auto
from typing import NamedTuple, Protocol

from fieldrig_devices.motion.travel import NEGATIVE, POSITIVE


class Kind(Enum):
    """Quantities that a set value can be."""

    POSITION = auto()
    """Increments."""
    VELOCITY = auto()
    """Increments per second."""
    TORQUE = auto()
    """0.1 % of the motor's rated torque."""


class Switch(IntEnum):
    """Bits of the digital inputs (60FDh)."""

    NEGATIVE_LIMIT = NEGATIVE
    POSITIVE_LIMIT = POSITIVE
    HOME = 0x4


class Captured(NamedTuple):
    """An edge of an input, captured between two cycles."""

    position: int
    """Increments."""
    time_ns: int


class Motor(Protocol):
    @property
    def kinds(self) -> frozenset[Kind]:
        """The kinds of set values that the motor can follow."""

    @property
    def is_there(self) -> bool: ...

    @property
    def is_ready(self) -> bool:
        """True if power is on and the motor can be enabled."""

    @property
    def is_following(self) -> bool: ...

    @property
    def is_stopping(self) -> bool:
        """True while the motor stops on its own and follows no set values."""

    @property
    def errors(self) -> tuple[int, ...]:
        """Present error codes as in 603Fh, in the order in which they occurred."""

    @property
    def has_warning(self) -> bool: ...

    @property
    def position(self) -> int: ...

    @property
    def velocity(self) -> float: ...

    @property
    def torque(self) -> int:
        """Actual torque, in 0.1 % of the rated torque."""

    @property
    def current(self) -> int:
        """Actual current, in 0.1 % of the rated current."""

    @property
    def torque_by_current(self) -> float:
        """Share of the rated torque that the rated current gives; 1 if they belong together."""

    @property
    def rated_torque_mnm(self) -> int: ...

    @property
    def rated_current_ma(self) -> int: ...

    @property
    def dc_link_mv(self) -> int:
        """Voltage of the DC link circuit, in mV; 0 if it is unknown."""

    @property
    def revolution(self) -> int:
        """Increments between two encoder zeros."""

    @property
    def largest_speed(self) -> float:
        """The speed that its loops do not exceed, in increments per second; infinite if it is unknown."""

    @property
    def inputs(self) -> int:
        """Digital inputs as in 60FDh: those of `Switch`, and further inputs from bit 16 up."""

    def captured(self, bit: int) -> "Captured | None":
        """The last edge of the input of this bit, if the motor captures it; None if it samples inputs once a cycle."""

    def enable(self, is_on: bool) -> None: ...

    def limit_torque(self, most: int) -> None:
        """Limit the torque in all modes, in 0.1 % of the rated torque; may take effect many cycles later."""

    def set_outputs(self, outputs: int, mask: int) -> None:
        """Set the digital outputs as in 60FEh: bit 0 applies the brake, those from bit 16 up are the maker's."""

    def reset(self, done: Callable[[], None]) -> None:
        """Reset the error, then call `done`, possibly many cycles later."""


def passed_zero(before: int, now: int, revolution: int) -> int | None:
    """The last encoder zero between two positions, or None if there is none."""
    if now > before:
        zero = now // revolution * revolution
        return zero if zero > before else None
    zero = -(-now // revolution) * revolution
    return zero if zero < before else None
