"""The values behind the registers of an ST1."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.pamring.registers import Parameter, Primary, Variable
from fieldrig_devices.st1.boards import STAMPED, Boards
from fieldrig_devices.st1.registers import COUNT, Registers, Source, parameter_sources
from fieldrig_devices.st1.sensors import Sensors
from fieldrig_devices.st1.servo import Servo
from fieldrig_devices.st1.settings import ParameterSettings, RegisterSettings

FIRST_OUTPUT: Final = 8
HALF: Final = 16
"""Bits of a half of the status word ABCD."""


def registers_of(
    servo: Servo, boards: Boards, sensors: Sensors, now_ns: Callable[[], int], further: dict[str, dict[int, int]]
) -> Registers:
    """Return the registers of an axis; `further` has those of the rig file by kind and code, and may change."""
    own = servo.settings.parameters
    variables = _variables(servo, boards, sensors, now_ns) | _further(further["variables"])
    parameters = parameter_sources(own) | {Parameter.DAP_TEMP: lambda: sensors.temperature}
    return Registers(_primary(servo, sensors, now_ns), variables, parameters | _further(further["parameters"]))


def initial_values(settings: dict[int, RegisterSettings]) -> dict[int, int]:
    return {code: register.value for code, register in settings.items()}


def _further(values: dict[int, int]) -> dict[int, Source]:
    return {code: lambda code=code: values[code] for code in values}  # type: ignore[misc]  # a default of a lambda


def _primary(servo: Servo, sensors: Sensors, now_ns: Callable[[], int]) -> dict[Primary, Source]:
    return {
        Primary.MAIN_RESOLVER: lambda: servo.shaft.position_at(now_ns()) // COUNT,
        Primary.SECOND_RESOLVER: lambda: sensors.second_counts,
        Primary.SET_POINT: lambda: servo.set.motor_at(now_ns()) // COUNT,
        Primary.INCREMENTAL_ENCODER: lambda: sensors.incremental_counts,
        Primary.ANALOG: lambda: sensors.analog,
    }


def _variables(servo: Servo, boards: Boards, sensors: Sensors, now_ns: Callable[[], int]) -> dict[int, Source]:
    own = servo.settings.parameters
    return {
        Variable.PHIRE: lambda: servo.shaft.position_at(now_ns()) // COUNT,
        Variable.PHIRE_2: lambda: sensors.second_counts,
        Variable.PHIC: lambda: servo.set.motor_at(now_ns()) // COUNT,
        Variable.SPEED: lambda: round(servo.shaft.speed_at(now_ns()) / COUNT),
        Variable.SET_SPEED: lambda: round(servo.set.speed_at(now_ns()) / COUNT),
        Variable.LAG: lambda: servo.shaft.lag_at(now_ns()) // COUNT,
        Variable.TORQUE_LIMIT: lambda: round(servo.torque.limit * 1000),
        Variable.STATUS_AB: lambda: servo.errors.value >> HALF,
        Variable.STATUS_CD: lambda: servo.errors.value,
        Variable.INPUTS: lambda: _logical_inputs(boards, own),
        Variable.OUTPUTS: lambda: sum(level << number - FIRST_OUTPUT for number, level in boards.outputs.items()),
        Variable.SUPPLY: lambda: round(sensors.supply_v),
    }


def _logical_inputs(boards: Boards, own: ParameterSettings) -> int:
    """IN 31 to IN 16 as the local actions of the ST1 see them: with the levels of CACTIN, and those of CVALIN only."""
    levels = sum(boards.levels.get(STAMPED + bit, False) << bit for bit in range(16))
    return ~(levels ^ own.cactin) & own.cvalin
