"""The values that an axis shows in the object dictionary: actual values, demands, and its capabilities."""

from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_drive import AxisDrive
from fieldrig_devices.cia402.axis_objects import AxisObjects
from fieldrig_devices.cia402.context import Context
from fieldrig_devices.cia402.modes.velocity import Velocity
from fieldrig_devices.cia402.motor import Kind, Motor
from fieldrig_devices.cia402.units import BITS_32


def show(numbers: AxisObjects, context: Context, motor: Motor, drive: AxisDrive) -> None:
    """Connect all of these objects but the status word, the mode and the error code."""
    velocity = drive.modes[Velocity.number]
    assert isinstance(velocity, Velocity)
    for index, read in (
        (objects.POSITION_DEMAND, lambda: context.shown(drive.position_demand)),
        (objects.POSITION_INTERNAL, lambda: BITS_32.shown(motor.position)),
        (objects.POSITION_ACTUAL, lambda: context.shown(motor.position)),
        (objects.VELOCITY_DEMAND, lambda: context.units.velocity(drive.velocity_demand)),
        (objects.VL_DEMAND, lambda: velocity.shown(drive.velocity_demand if drive.mode is velocity else 0.0)),
        (objects.VL_ACTUAL, lambda: velocity.shown(motor.velocity)),
        (objects.VELOCITY_ACTUAL, lambda: context.units.velocity(motor.velocity)),
        (objects.TORQUE_DEMAND, lambda: round(drive.set_value) if drive.kind is Kind.TORQUE else 0),
        (objects.RATED_CURRENT, lambda: motor.rated_current_ma),
        (objects.RATED_TORQUE, lambda: motor.rated_torque_mnm),
        (objects.TORQUE_ACTUAL, lambda: motor.torque),
        (objects.CURRENT_ACTUAL, lambda: motor.current),
        (objects.DC_LINK, lambda: motor.dc_link_mv),
        (objects.FOLLOWING_ERROR, lambda: context.units.length(drive.following_error)),
        (objects.DEMAND_INTERNAL, lambda: BITS_32.shown(round(drive.position_demand))),
        (objects.INPUTS, lambda: motor.inputs),
        (objects.SUPPORTED_MODES, lambda: sum(1 << (number - 1) for number in drive.supported if number > 0)),
        (objects.DEVICE_TYPE, lambda: objects.SERVO_DRIVE if motor.is_there else 0),
    ):
        numbers.read_by(index, read)
