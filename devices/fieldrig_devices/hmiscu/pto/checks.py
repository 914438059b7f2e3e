"""The checks of a motion command's inputs: ranges of the pins, and directions (digest 8.1).

A wrong input ends the command with PTO_INVALID_PARAMETER, whatever bits the diagnosis has for it.
"""

from typing import NamedTuple

from fieldrig_devices.hmiscu.enumerations import Direction
from fieldrig_devices.hmiscu.pto.command import Order
from fieldrig_devices.hmiscu.pto.matrix import Next
from fieldrig_devices.hmiscu.pto.settings import LARGEST_DISTANCE, LONGEST_RAMP_MS, PtoSettings
from fieldrig_devices.hmiscu.pto.status import Diagnosis


class Situation(NamedTuple):
    """The channel as a check sees it."""

    settings: PtoSettings
    start_hz: int
    stop_hz: int
    moving: Direction | None
    """Direction of a motion that the command would change; None from standstill."""


class Wrong(NamedTuple):
    """Result of the checks: whether anything is wrong, and the bits of it."""

    is_wrong: bool
    bits: Diagnosis


def check(order: Order, situation: Situation) -> Wrong:
    """Return everything that is wrong with the inputs of a command."""
    acceleration_max, deceleration_max, _ = situation.settings.limits
    bits, is_wrong = Diagnosis.NONE, False
    if not _is_ramp(situation.settings, order.deceleration, deceleration_max):
        bits |= Diagnosis.INVALID_DECELERATION
    if order.kind is not Next.STOP:
        if not _is_ramp(situation.settings, order.acceleration, acceleration_max):
            bits |= Diagnosis.INVALID_ACCELERATION
        if not _lowest(order.kind, situation) <= order.velocity <= situation.settings.maximum_frequency_hz:
            bits |= Diagnosis.INVALID_FREQUENCY
        if not _is_direction(order.direction, situation.moving):
            bits |= Diagnosis.INVALID_DIRECTION
    if order.kind is Next.MOVE_RELATIVE:
        is_wrong = not 1 <= order.distance <= LARGEST_DISTANCE
    return Wrong(is_wrong or bool(bits), bits)


def _is_ramp(settings: PtoSettings, pin: int, limit: int) -> bool:
    """Return whether a pin is in range: a rate up to the limit, or a time from the limit on (SCU-037)."""
    return 1 <= pin <= limit if settings.ramp_unit == "Hz/ms" else limit <= pin <= LONGEST_RAMP_MS


def _lowest(kind: Next, situation: Situation) -> int:
    """Return the lowest velocity in Hz.  A velocity in motion may be below the start frequency (SCU-034, SCU-048)."""
    if kind is Next.MOVE_RELATIVE:
        return max(situation.start_hz, situation.stop_hz, 1)
    return 1 if situation.moving is not None else max(situation.start_hz, 1)


def _is_direction(pin: int, moving: Direction | None) -> bool:
    """Return whether a direction exists and does not reverse a motion."""
    if pin == Direction.PTO_CURRENT:
        return True
    return pin in (Direction.PTO_POSITIVE, Direction.PTO_NEGATIVE) and (moving is None or pin == moving)
