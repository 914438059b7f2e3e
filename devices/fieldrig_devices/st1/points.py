"""The points of an ST1: values to read, and inputs to write while no wire drives them."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Protocol

from fieldrig.device import Point, Value
from fieldrig.points.checks import number_in, truth_in, whole_in
from fieldrig_devices.pamring.axis_words import Error
from fieldrig_devices.pamring.node import RingNode
from fieldrig_devices.pamring.points import ring_points
from fieldrig_devices.st1.program import Program
from fieldrig_devices.st1.registers import COUNT
from fieldrig_devices.st1.sensors import FULL_SCALE_V, Sensors
from fieldrig_devices.st1.settings import INPUTS
from fieldrig_devices.st1.shaft import TURN


class Node(Protocol):
    """The device, as its points see it."""

    program: Program
    sensors: Sensors
    further: dict[str, dict[int, int]]

    def put_load(self, load_nm: float) -> None: ...

    def put_temperature(self, degc: float) -> None: ...

    def put_supply(self, volts: float) -> None: ...

    def put_auxiliary(self, is_there: bool) -> None: ...


def points_of(node: Node, end: RingNode) -> Mapping[str, Point]:
    return {**_motion(node), **_state(node, end), **_inputs(node), **_terminals(node), **_registers(node)}


def _motion(node: Node) -> dict[str, Point]:
    servo, shaft, setting = node.program.servo, node.program.servo.shaft, node.program.servo.set

    def of_motor(value: Callable[[int], float]) -> Callable[[], float]:
        return lambda: value(servo.now_ns()) / TURN

    return {
        "position": Point(
            of_motor(lambda now_ns: setting.named(shaft.position_at(now_ns))), None, "turn", "as the PAM names it"
        ),
        "set_position": Point(of_motor(setting.name_at), None, "turn", "as the PAM names it"),
        "motor": Point(of_motor(shaft.position_at), None, "turn", "since the start"),
        "speed": Point(of_motor(shaft.speed_at), None, "turn/s", "of the motor"),
        "set_speed": Point(of_motor(setting.speed_at), None, "turn/s", "of the motor"),
        "lag": Point(of_motor(shaft.lag_at), None, "turn", "from the shaft to the set position"),
        "torque": Point(lambda: servo.torque_nm, None, "N m", "of the motor, with which it moves, brakes or pushes"),
        "torque_limit": Point(lambda: servo.torque.limit * 100, None, "%", "of the largest torque, by a pipe"),
    }


def _state(node: Node, end: RingNode) -> dict[str, Point]:
    servo = node.program.servo
    return {
        **ring_points(end),
        "power": Point(lambda: servo.is_powered, None, "", "the power stage is on"),
        "status": Point(lambda: servo.status, None, "", "status word of the axis, table 12-4"),
        "error": Point(lambda: servo.errors.value, None, "", "error word of the axis, table 12-1"),
        "errors": Point(lambda: _names(servo.errors.value), None, "", "names of the bits of the error word"),
        "order": Point(lambda: servo.answers.done, None, "", "number of the last order that is done"),
    }


def _names(word: int) -> str:
    return " ".join(error.name for error in Error if word & error and error.name is not None)


def _inputs(node: Node) -> dict[str, Point]:
    servo, sensors = node.program.servo, node.sensors

    def number(put: Callable[[float], None], unit: str) -> Callable[[Value], None]:
        return lambda value: put(float(number_in(value, unit=unit)))

    def put_analog(value: Value) -> None:
        sensors.analog_v = float(number_in(value, -FULL_SCALE_V, FULL_SCALE_V, "V"))

    return {
        "enable": Point(
            lambda: servo.causes.enable,
            lambda value: servo.switch(truth_in(value)),
            "",
            "the input enables the power stage",
        ),
        "load_torque": Point(
            lambda: servo.torque.load_nm * servo.settings.motor.gear_ratio,
            number(node.put_load, "N m"),
            "N m",
            "at the load; it acts like friction",
        ),
        "motor_temperature": Point(
            lambda: sensors.temperature_degc, number(node.put_temperature, "degC"), "degC", "of the motor"
        ),
        "supply": Point(lambda: sensors.supply_v, number(node.put_supply, "V"), "V", "UA"),
        "auxiliary": Point(
            lambda: not servo.causes.outer & Error.AUX_SUPPLY_FAILURE,
            lambda value: node.put_auxiliary(truth_in(value)),
            "",
            "the auxiliary supply",
        ),
        "analog": Point(lambda: sensors.analog_v, put_analog, "V", "the analog input"),
        "second": Point(lambda: sensors.second_counts / COUNT, None, "turn", "the second resolver"),
        "incremental": Point(lambda: sensors.incremental_counts, None, "count", "the incremental encoder"),
    }


def _terminals(node: Node) -> dict[str, Point]:
    boards = node.program.boards

    def level(levels: Mapping[int, bool], number: int) -> bool:
        return levels.get(number, False)

    def put(number: int, value: Value) -> None:
        boards.put(number, truth_in(value))

    points = {
        f"IN{number}": Point(partial(level, boards.levels, number), partial(put, number), "", "input; true is 24 V")
        for number in INPUTS
    }
    for number in boards.outputs:
        points[f"OUT{number}"] = Point(partial(level, boards.outputs, number), None, "", "output; true is 24 V")
    return points


def _registers(node: Node) -> dict[str, Point]:
    def read(kind: str, code: int) -> int:
        return node.further[kind][code]

    def write(kind: str, code: int, value: Value) -> None:
        node.further[kind][code] = whole_in(value, -(1 << 31), (1 << 32) - 1)

    return {
        f"{kind}/{code}": Point(partial(read, kind, code), partial(write, kind, code), "", "register of the rig file")
        for kind, registers in node.further.items()
        for code in registers
    }
