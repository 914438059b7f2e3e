"""The name plate as a file, and an encoder that has it in its memory, inside the drive.

Source: manual 513-540, 4168; digest PD-170 to PD-177: what the plate has to say is in the manual's words, its format is
not.  The encoder proper, with its line and its bytes, is a device of its own; this one only takes its time.
"""

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path
from typing import Final

from fieldrig.clock import MS, Clock
from fieldrig.yaml_source import read
from fieldrig_devices.mc4.motor import INCREMENTS_PER_TURN, MotorData

READ_NS: Final = 250 * MS
"""For a plate of some hundred bytes at 9600 baud."""


class PlateError(ValueError):
    """A file that is no name plate; its text says why."""


def load_plate(path: Path) -> MotorData:
    """PlateError for anything else."""
    source = read(path.read_text(encoding="utf-8"), str(path))
    if source.mistakes:
        raise PlateError(f"{path.name}: {source.mistakes[0].what}")
    if not isinstance(source.data, dict):
        raise PlateError(f"{path.name}: a name plate has keys like rated_torque_nm: 6.3")
    return plate_of(source.data, path.name)


def plate_of(values: dict[str, object], where: str) -> MotorData:
    kinds = {field.name: field.type for field in fields(MotorData)}
    taken: dict[str, object] = {}
    for key, value in values.items():
        kind = kinds.get(key)
        if kind is None:
            raise PlateError(f"{where}: a name plate has no key {key!r}; there are {', '.join(kinds)}")
        if kind is float and isinstance(value, int) and not isinstance(value, bool):
            value = float(value)
        if type(value) is not kind:
            raise PlateError(f"{where}: {key} must be a {getattr(kind, '__name__', kind)}, not {value!r}")
        taken[key] = value
    return checked(MotorData(**taken), where)  # type: ignore[arg-type]  # each was compared with its field's type


POSITIVE: Final = (
    "rated_speed_rpm", "max_speed_rpm", "rated_torque_nm", "standstill_torque_nm", "peak_torque_nm",
    "torque_constant_nm_per_a", "inertia_kgcm2", "pole_pairs", "thermal_time_s",
)  # fmt: skip


def checked(motor: MotorData, where: str) -> MotorData:
    """PlateError for figures that no motor has."""
    for name in POSITIVE:
        value = getattr(motor, name)
        if not 0 < value < 1e6:
            raise PlateError(f"{where}: {name} must be above 0, not {value!r}")
    if motor.peak_torque_nm < motor.standstill_torque_nm or motor.brake_torque_nm < 0:
        raise PlateError(f"{where}: peak_torque_nm is at least standstill_torque_nm, brake_torque_nm at least 0")
    return motor


class InnerEncoder:
    def __init__(self, clock: Clock, motor: MotorData | None, turns: float) -> None:
        """Without a motor it never answers."""
        self._clock, self._motor = clock, motor
        self._increments = round(turns * INCREMENTS_PER_TURN)

    def read_plate(self, done: Callable[[MotorData | None], None]) -> None:
        self._clock.call_at(self._clock.now_ns() + READ_NS, lambda: done(self._motor))

    def read_position(self, done: Callable[[int | None], None]) -> None:
        motor = self._motor
        done(None if motor is None else self._increments % (motor.range_turns * INCREMENTS_PER_TURN))
