"""What a drive measures and shows, as the whole numbers of its operation data.

Units are those of `idns`.  Positions are counted on inside the drive, and go over the ring modulo 2^32.
"""

from collections.abc import Callable
from math import tau
from typing import Final

from fieldrig_devices.mc4 import idns
from fieldrig_devices.mc4.axis import INCREMENTS
from fieldrig_devices.mc4.machine import Machine

SPEED_UNIT: Final = tau / 60 * 1e-4
"""rad/s of one 0.0001 1/min."""
_HALF, _ALL = 0x8000_0000, 0xFFFF_FFFF
Number = Callable[[], int]
STANDING: Final = frozenset({11, 129, 182, 390, idns.MC4_STATE, idns.AXIS_STATE, idns.SIGNALS, idns.DIAG_CODE})
"""Those that only change when the machine is looked at, not with every cycle."""


def live_numbers(machine: Machine) -> dict[int, Number]:
    """By IDN."""
    settings = machine.settings

    def position() -> int:
        axis = machine.axis
        return (round(axis.set_increments - axis.e * INCREMENTS) + _HALF & _ALL) - _HALF

    def load_position() -> int:
        axis = machine.axis
        return (round(axis.position - axis.twist * INCREMENTS) + _HALF & _ALL) - _HALF

    def torque() -> int:
        number = round(machine.axis.t * 1000 / machine.true_motor.standstill_torque_nm)
        return number if -32_768 <= number <= 32_767 else max(-32_768, min(number, 32_767))

    def velocity() -> int:
        number = round(machine.axis.v / SPEED_UNIT)
        return number if -_HALF <= number < _HALF else max(-_HALF, min(number, _HALF - 1))

    def following() -> int:
        return max(-_HALF, min(round(machine.axis.e * INCREMENTS), _HALF - 1))

    def signals() -> int:
        chain = machine.chain
        lifted = chain.is_brake_lifted << 1
        return machine.is_ready | lifted | machine.hardware_enable << 2 | chain.has_torque << 3

    return {
        11: lambda: machine.diagnosis.class_1,
        40: velocity,
        51: position,
        53: load_position,
        84: torque,
        129: lambda: machine.diagnosis.manufacturer_class_1,
        182: lambda: machine.chain.axis_state << 8 | machine.chain.mc4_state,
        189: following,
        380: lambda: min(round(machine.dc.volt), 32_767),
        383: lambda: round(machine.thermal.motor_c * 10),
        384: lambda: round(machine.thermal.amplifier_c * 10),
        390: lambda: int(machine.diagnosis.code),
        110: lambda: round(settings.amplifier.continuous_current_a * 2500),
        112: lambda: round(settings.amplifier.continuous_current_a * 1000),
        idns.MC4_STATE: lambda: machine.chain.mc4_state,
        idns.AXIS_STATE: lambda: machine.chain.axis_state,
        idns.MOTOR_OVERLOAD: lambda: min(round(machine.thermal.motor_load * 1000), 65_535),
        idns.AMPLIFIER_OVERLOAD: lambda: min(round(machine.thermal.amplifier_load * 1000), 65_535),
        idns.OVERLOAD_POSITION: lambda: (machine.overload_position + _HALF & _ALL) - _HALF,
        idns.SIGNALS: signals,
        idns.DIAG_CODE: lambda: int(machine.diagnosis.code),
    }
