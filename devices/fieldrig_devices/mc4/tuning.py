"""The constants of an axis: the loops and limits from parameters and name plate.

Source: manual 520 (the drive configures itself), 525 and 534 (250 %, 4-fold), 6578-7049 (regulators).  If the
master does not write a gain, the speed regulator is tuned for its load.
"""

from math import tau
from typing import Final

from fieldrig_devices.drives.load import all_inertia, bandwidth
from fieldrig_devices.drives.loops import Gains, Limits
from fieldrig_devices.drives.motor import MotorData
from fieldrig_devices.mc4.settings import Mc4Settings
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable

PEAK: Final = 2.5
"""Overload of the amplifier (manual 525)."""
RPM: Final = 60 / tau
KV_UNIT: Final = 1000 / 60
"""A gain of 1 (m/min)/mm, in 1/s."""


def tune(table: IdnTable, settings: Mc4Settings, motor: MotorData) -> None:
    """Set the parameters that follow from the name plate, unless the rig file gives them."""
    given = settings.parameters.idns
    if "S-0-0100" not in given:
        kp = all_inertia(settings.load, motor) * bandwidth(settings.load)
        table[std.VELOCITY_LOOP_GAIN].set(max(1, round(kp / motor.torque_constant_nm_per_a * 1e3)))
    if "S-0-0091" not in given:
        table[std.VELOCITY_LIMIT].set(round(motor.max_speed_rpm * 1e4))


def gains_of(table: IdnTable, settings: Mc4Settings, motor: MotorData, *, is_lagless: bool) -> Gains:
    kp = table[std.VELOCITY_LOOP_GAIN].number / 1e3 * motor.torque_constant_nm_per_a
    kp = kp or all_inertia(settings.load, motor) * bandwidth(settings.load)
    seconds = table[std.VELOCITY_LOOP_ACTION_TIME].number / 1e4
    ff = table[std.VELOCITY_FEED_FORWARD].number / 1000 if is_lagless else 0.0
    return Gains(table[std.KV_FACTOR].number / 100 * KV_UNIT, kp, kp / seconds if seconds else 0.0, ff)


def limits_of(table: IdnTable, settings: Mc4Settings, motor: MotorData) -> Limits:
    amplifier_nm = settings.amplifier.continuous_current_a * PEAK * motor.torque_constant_nm_per_a
    limit_nm = table[std.TORQUE_LIMIT].number / 1000 * motor.standstill_torque_nm
    limit_rpm = table[std.VELOCITY_LIMIT].number / 1e4 or motor.max_speed_rpm
    most = min(motor.peak_torque_nm, amplifier_nm, limit_nm)
    fastest = min(motor.max_speed_rpm, limit_rpm) / RPM
    return Limits(max(most, 1e-6), max(fastest, 1e-6))


def lead_inertia(table: IdnTable, settings: Mc4Settings, motor: MotorData) -> float:
    """Return the inertia that the current feed-forward assumes."""
    return all_inertia(settings.load, motor) * table[std.ACCELERATION_FEED_FORWARD].number / 1000
