"""The constants of an axis: plant from motor and load, the loops and limits from parameters and name plate.

Source: manual 520 (the drive configures itself), 525 and 534 (250 %, 4-fold), 6578-7049 (regulators).  If the
master does not write a gain, the speed regulator is tuned for its load.
"""

from math import sqrt, tau
from typing import Final

from fieldrig_devices.drives.motor import MotorData
from fieldrig_devices.mc4.loops import Elastic, Gains, Limits, Plant
from fieldrig_devices.mc4.settings import LoadSettings, Mc4Settings
from fieldrig_devices.sercos import standard_idns as std
from fieldrig_devices.sercos.datum import IdnTable

PEAK: Final = 2.5
"""Overload of the amplifier (manual 525)."""
BANDWIDTH: Final = 400.0
"""Bandwidth to which the speed regulator is tuned, in rad/s."""
RPM: Final = 60 / tau
KV_UNIT: Final = 1000 / 60
"""A gain of 1 (m/min)/mm, in 1/s."""


def plant_of(load: LoadSettings, motor: MotorData) -> Plant:
    if load.stiffness_nm_per_rad is None:
        return Plant(all_inertia(load, motor), load.viscous_nm_s_per_rad)
    square = load.gear_ratio**2
    inertia, stiffness, damping = (
        value / square for value in (load.inertia_kg_m2, load.stiffness_nm_per_rad, load.damping_nm_s_per_rad)
    )
    return Plant(motor.inertia_kg_m2, load.viscous_nm_s_per_rad, elastic=Elastic(inertia, stiffness, damping))


def all_inertia(load: LoadSettings, motor: MotorData) -> float:
    """Return the inertia of motor and load, referred to the motor."""
    return motor.inertia_kg_m2 + load.inertia_kg_m2 / load.gear_ratio**2


def bandwidth(load: LoadSettings) -> float:
    """Return the bandwidth of the speed regulator, well below the resonance of an elastic coupling."""
    if load.stiffness_nm_per_rad is None:
        return BANDWIDTH
    return min(BANDWIDTH, 0.5 * sqrt(load.stiffness_nm_per_rad / load.inertia_kg_m2))


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
