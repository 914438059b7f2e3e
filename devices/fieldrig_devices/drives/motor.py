"""The data of a motor, and the encoder from which a drive reads them.

Source: manual 513-540, 6446-6456, 6933, 6951-6961 (the words of a name plate; digest PD-170 to PD-177).  The motor's
encoder stores the plate in its memory; `Encoder` is the drive's interface to it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, Protocol

INCREMENTS_PER_TURN: Final = 1_000_000
"""Manual 6933."""
TURNS: Final = 4096
"""Turns that a multi-turn encoder distinguishes (manual 6448)."""


@dataclass(frozen=True, slots=True)
class MotorData:
    """A name plate.  The defaults are those of a typical servo motor, our choice."""

    type: str = "SM-100/30/080/P1/45"
    serial_number: str = "0000000001"
    rated_speed_rpm: float = 3000.0
    max_speed_rpm: float = 5000.0
    """Mechanical limit."""
    rated_torque_nm: float = 6.3
    standstill_torque_nm: float = 8.0
    peak_torque_nm: float = 32.0
    """Peak torque, 4-fold (manual 534)."""
    torque_constant_nm_per_a: float = 1.6
    """Standstill torque over standstill current (manual 7103)."""
    inertia_kgcm2: float = 4.2
    pole_pairs: int = 4
    is_multi_turn: bool = True
    brake_torque_nm: float = 0.0
    """Torque of the holding brake; 0 without a brake."""
    brake_lift_ms: float = 40.0
    brake_drop_ms: float = 20.0
    winding_limit_c: float = 140.0
    """Temperature at which the thermo contact opens."""
    thermal_time_s: float = 1800.0
    """Thermal time constant of the casing."""

    @property
    def has_brake(self) -> bool:
        return self.brake_torque_nm > 0

    @property
    def inertia_kg_m2(self) -> float:
        return self.inertia_kgcm2 * 1e-4

    @property
    def standstill_current_a(self) -> float:
        return self.standstill_torque_nm / self.torque_constant_nm_per_a

    @property
    def peak_current_a(self) -> float:
        return self.peak_torque_nm / self.torque_constant_nm_per_a

    @property
    def rated_current_a(self) -> float:
        return self.rated_torque_nm / self.torque_constant_nm_per_a

    @property
    def range_turns(self) -> int:
        """Number of turns after which the absolute position repeats."""
        return TURNS if self.is_multi_turn else 1


class Encoder(Protocol):
    """The motor's encoder with its memory, as the drive sees it.  `done` may be called at once or later."""

    def read_plate(self, done: Callable[[MotorData | None], None]) -> None:
        """Read the plate; `done` gets None if there is no readable plate."""

    def read_position(self, done: Callable[[int | None], None], on_asked: Callable[[], None]) -> None:
        """Read the absolute position in increments, from 0, at the instant of `on_asked`; None without an answer."""
