"""The points of a drive: values to read, and inputs to write."""

from collections.abc import Callable, Mapping

from fieldrig.device import Point, Value
from fieldrig.points.checks import number_in, truth_in
from fieldrig_devices.drives.loops import INCREMENTS, RAD
from fieldrig_devices.drives.position_wire import DECIMALS, POSITION_DECIMALS
from fieldrig_devices.mc4.machine import Machine
from fieldrig_devices.mc4.ring_side import RingSide
from fieldrig_devices.mc4.tuning import RPM
from fieldrig_devices.mc4.values import GUARD

LARGEST_LOAD_NM = 1e6


def points_of(
    machine: Machine,
    side: RingSide,
    gear: float,
    plate: Callable[[], str],
    set_inverter_enable: Callable[[bool], None],
) -> Mapping[str, Point]:
    return {
        **_state_points(machine, side, plate, set_inverter_enable),
        **_motion_points(machine, gear),
        **_power_points(machine),
    }


def _state_points(
    machine: Machine, side: RingSide, plate: Callable[[], str], set_inverter_enable: Callable[[bool], None]
) -> dict[str, Point]:
    chain = machine.chain

    def acknowledge(value: Value) -> None:
        if not truth_in(value):
            raise ValueError("expected true, got false")
        if not machine.quit():
            raise ValueError("the drive is still stopping, or the cause of the error is still present")

    return {
        "axis_state": Point(lambda: chain.axis_state, None, "", "AxisState"),
        "mc4_state": Point(lambda: chain.mc4_state, None, "", "MC4State"),
        "stage": Point(lambda: chain.stage.name.lower(), None, "", "stage of the enable chain"),
        "diag_code": Point(lambda: int(machine.diagnosis.code), None, "", "DiagCode; 0 while no message is pending"),
        "diag_msg": Point(lambda: machine.diagnosis.text, None, "", "DiagMsg"),
        "quit": Point(lambda: not machine.diagnosis.code, acknowledge, "", "write true to acknowledge errors"),
        "inverter_enable": Point(
            lambda: machine.hardware_enable,
            lambda value: set_inverter_enable(truth_in(value)),
            "",
            "the input Inverter Enable (safe stop)",
        ),
        "controller_enable": Point(lambda: machine.controller, None, "", "ControllerEnable, from the ring"),
        "ready": Point(lambda: machine.is_ready, None, "", "the ready contact is closed"),
        "brake": Point(lambda: chain.is_brake_lifted, None, "", "the brake relay is closed, so the brake lifts"),
        "torque_on": Point(lambda: chain.has_torque, None, "", "the motor is not free"),
        "phase": Point(lambda: side.slave.phase, None, "", "phase of the ring, CP0 to CP4"),
        "status": Point(side.status, None, "", "status word, S-0-0135, without the service channel"),
        "motor_type": Point(lambda: machine.motor.type if machine.motor else "", None, "", "from the name plate"),
        "motor_serial": Point(
            lambda: machine.motor.serial_number if machine.motor else "", None, "", "from the name plate"
        ),
        "plate": Point(plate, None, "", "whether the name plate was read, or why not"),
    }


def _motion_points(machine: Machine, gear: float) -> dict[str, Point]:
    def current() -> float:
        return shown(machine.present.torque / machine.true_motor.torque_constant_nm_per_a)

    def load_position() -> float:
        shaft = machine.present_shaft
        return round((shaft.position * RAD - shaft.twist) / gear, POSITION_DECIMALS)

    return {
        "position": Point(
            lambda: round(machine.present.position + GUARD), None, "incr", "of the motor, 1 000 000 per turn"
        ),
        "speed": Point(lambda: shown(machine.present.speed * RPM), None, "1/min", "of the motor"),
        "torque": Point(lambda: shown(machine.present.torque), None, "N m", "of the motor"),
        "current": Point(current, None, "A"),
        "following_error": Point(lambda: round(machine.present.error * INCREMENTS + GUARD), None, "incr"),
        "load_position": Point(load_position, None, "rad"),
        "load_torque": Point(
            lambda: machine.load_nm,
            lambda value: machine.set_load(limited_load(float(number_in(value, unit="N m")))),
            "N m",
            "at the load, in addition to the configured torque; positive acts backwards",
        ),
        "brake_on": Point(lambda: machine.axis.brake_is_on, None, "", "the holding brake is applied"),
        "slow_cycles": Point(
            lambda: machine.axis.slow_cycles, None, "", "number of cycles that took the steps instead of the fold"
        ),
    }


def _power_points(machine: Machine) -> dict[str, Point]:
    def set_mains(value: Value) -> None:
        machine.switch_mains(truth_in(value))

    def set_ambient(value: Value) -> None:
        machine.energy.thermal.ambient_c = float(number_in(value, -273, 10_000, "degC"))

    return {
        "mains": Point(lambda: machine.energy.dc.is_mains_on, set_mains, "", "supply of this drive"),
        "dc_bus": Point(lambda: shown(machine.present_dc.volt), None, "V", "DC circuit"),
        "motor_temperature": Point(lambda: shown(machine.present_thermal.motor_c), None, "degC", "of the winding"),
        "casing_temperature": Point(lambda: shown(machine.present_thermal.casing_c), None, "degC", "of the motor"),
        "amplifier_temperature": Point(lambda: shown(machine.present_thermal.amplifier_c), None, "degC"),
        "ambient": Point(lambda: machine.energy.thermal.ambient_c, set_ambient, "degC"),
        "overload": Point(
            lambda: shown(machine.present_thermal.overload * 100), None, "%", "at 100 % the drive switches off"
        ),
    }


def shown(measured: float) -> float:
    return round(measured, DECIMALS)


def limited_load(torque_nm: float) -> float:
    return min(max(torque_nm, -LARGEST_LOAD_NM), LARGEST_LOAD_NM)
