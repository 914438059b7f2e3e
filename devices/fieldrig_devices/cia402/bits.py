"""The bits of the status word whose meaning depends on the maker: 4, 14 and 15.

Source: CiA 402-2, table 'status word': bit 4 says that the power stage has voltage, which makers read differently; bits
14 and 15 are the maker's.
"""

from fieldrig_devices.cia402.behaviour import Behaviour, FreeBit, VoltageBit
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.motor import Motor


def has_voltage_bit(behaviour: Behaviour, motor: Motor, is_enabled: bool) -> bool:
    """Return bit 4."""
    meaning = behaviour.voltage_bit
    if meaning is VoltageBit.READY:
        return motor.is_ready
    return is_enabled if meaning is VoltageBit.ENABLED else motor.dc_link_mv > 0


def free_bits(behaviour: Behaviour, motor: Motor, context: Context) -> int:
    """Return bits 14 and 15."""
    word = 0x4000 if _holds(behaviour.bit_14, motor, context) else 0
    return word | (0x8000 if _holds(behaviour.bit_15, motor, context) else 0)


def _holds(meaning: FreeBit, motor: Motor, context: Context) -> bool:
    match meaning:
        case FreeBit.HOMED:
            return context.is_homed
        case FreeBit.BACKWARDS:
            return context.units.velocity_sign * motor.velocity < -context.threshold
        case FreeBit.STANDSTILL:
            return context.is_standing(motor.velocity)
        case FreeBit.WARNING:
            return motor.has_warning
        case _:
            return False
