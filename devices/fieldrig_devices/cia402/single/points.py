"""The points of a single drive besides those of its node: what its state is, what its motor does, and its terminals."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Final

from fieldrig.device import Point, Value
from fieldrig.points.checks import number_in, truth_in
from fieldrig_devices.cia402.axis import Cia402Axis
from fieldrig_devices.cia402.single.servo import RPM, Servo
from fieldrig_devices.cia402.single.settings import INPUTS
from fieldrig_devices.cia402.single.terminals import Inputs
from fieldrig_devices.drive_profile.states import State
from fieldrig_devices.drives.position_wire import DECIMALS, POSITION_DECIMALS

MOST_NM: Final = 1e6


def points_of(motor: Servo, axis: Cia402Axis, inputs: Inputs) -> Mapping[str, Point]:
    drive = axis.drive
    return {
        "state": Point(
            lambda: _words(axis.machine.state), about="state of the drive (CiA 402)", states=[*map(_words, State)]
        ),
        "mode": Point(lambda: drive.shown_mode, about="mode of operation, as in 6061h"),
        "error_code": Point(lambda: axis.error, about="present error, as in 603Fh; 0 if there is none"),
        "status_word": Point(lambda: axis.status_word, about="as in 6041h"),
        "position": Point(lambda: round(motor.load_position, POSITION_DECIMALS), None, "rad", "of the load"),
        "speed": Point(lambda: round(motor.present.speed * RPM, DECIMALS), None, "1/min", "of the motor"),
        "torque": Point(lambda: round(motor.present.torque, DECIMALS), None, "N m", "of the motor"),
        **_world_points(motor),
        **{name: _input_point(name, bit, inputs, motor) for name, bit in INPUTS.items()},
    }


def _world_points(motor: Servo) -> dict[str, Point]:
    def set_load(value: Value) -> None:
        motor.set_load(float(number_in(value, -MOST_NM, MOST_NM, "N m")))

    def switch(read: Callable[[], bool], act: Callable[[bool], None], about: str) -> Point:
        return Point(read, lambda value: act(truth_in(value)), about=about)

    return {
        "brake": Point(lambda: motor.is_brake_lifted, about="the drive lifts the holding brake"),
        "load_torque": Point(lambda: motor.load_nm, set_load, "N m", "external, at the load; positive acts backwards"),
        "blocked": switch(lambda: motor.is_blocked, motor.block, "the shaft is blocked"),
        "sto": switch(lambda: motor.may_turn, motor.switch_sto, "safe torque off permits a torque"),
        "mains": switch(lambda: motor.has_mains, motor.switch_mains, "supply of the power stage"),
    }


def _input_point(name: str, bit: int, inputs: Inputs, motor: Servo) -> Point:
    def write(value: Value) -> None:
        inputs.set(bit, truth_in(value))
        motor.on_input()

    return Point(partial(_is_on, bit, motor), write, about=f"input {name}, bit {bit} of 60FDh")


def _is_on(bit: int, motor: Servo) -> bool:
    return bool(motor.inputs >> bit & 1)


def _words(state: State) -> str:
    return state.name.lower().replace("_", " ")
