"""The block SLAVECAM: a cam that is added to the cams of an axis (PD-186).  Its name and details are ours.

It has the pins of CAM and can only begin while a cam of CAM or MultiCam3 moves the axis; otherwise lResult is -7.  What
counts is its way from its begin, so iYSetposMode and lrYSetposPos have no effect.  A new slave cam takes the place of
the one before it at once, and what has been added remains.
"""

from typing import Final

from fieldrig_devices.iec.host import NativeBlock
from fieldrig_devices.max4.libraries.cam import PINS, cam_block
from fieldrig_devices.max4.libraries.follower import CamFollower
from fieldrig_devices.max4.libraries.motion import Motion

TEXT: Final = "FUNCTION_BLOCK SLAVECAM" + PINS


def slave_cam_block(motion: Motion) -> NativeBlock:
    return cam_block(motion, CamFollower.overlay)
