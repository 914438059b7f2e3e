"""The velocity as the encoder has it: 6069h in increments per second, by the velocity encoder resolution 6090h.

Source: CiA 402-2.  6090h is increments per second to revolutions of the motor per second; it says what 6069h counts,
and neither 607Eh nor a unit of the user acts on it.  The drive has one encoder for position and velocity, so without
6090h, or where it is a value that no encoder has, such as 1 to 1, an increment is that of 608Fh.  Left out: 606Ah, as
there is no second sensor to select.
"""

from fieldrig_devices.canopen.datatypes import Integer
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.live import show_number
from fieldrig_devices.cia402.objects import VELOCITY_RESOLUTION, VELOCITY_SENSOR
from fieldrig_devices.cia402.single.foreign import FEWEST_INCREMENTS
from fieldrig_devices.cia402.single.servo import Servo


def show_velocity(dictionary: Dictionary, motor: Servo) -> None:
    """Connect 6069h, if the drive has it, with the motor."""
    variable = dictionary.get(VELOCITY_SENSOR, 0)
    if variable is not None and isinstance(variable.type, Integer):
        show_number(variable, lambda: round(motor.velocity * _scale(dictionary, motor.revolution)))


def _scale(dictionary: Dictionary, revolution: int) -> float:
    """Return the increments of 6090h per increment of 608Fh."""
    increments, turns = (_number(dictionary, subindex) for subindex in (1, 2))
    per_turn = increments / max(turns, 1)
    return per_turn / revolution if per_turn >= FEWEST_INCREMENTS else 1.0


def _number(dictionary: Dictionary, subindex: int) -> int:
    variable = dictionary.get(VELOCITY_RESOLUTION, subindex)
    return variable.number if variable is not None and isinstance(variable.type, Integer) else 0
