"""ControllerEnableSet (PD-163): sets ControllerEnable of an axis, by its logical address.

The manual's call gives only the address and sets the enable.  The function ControllerEnableReset is ours.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec.host import NativeFunction, Results
from fieldrig_devices.max4.libraries.controller import MotionController

TEXT: Final = """
(* TRUE if lAxisId is the logical address of an axis. *)
FUNCTION ControllerEnableSet : BOOL
VAR_INPUT
    lAxisId : DINT;
END_VAR
{native}
END_FUNCTION

FUNCTION ControllerEnableReset : BOOL
VAR_INPUT
    lAxisId : DINT;
END_VAR
{native}
END_FUNCTION
"""


def functions(controller: MotionController) -> Mapping[str, NativeFunction]:
    def enable(address: int, *, is_on: bool) -> Results:
        axis = controller.axis(address)
        if axis is not None:
            axis.enable(is_on)
        return (axis is not None,)

    return {
        "controllerenableset": NativeFunction(lambda address: enable(address, is_on=True)),
        "controllerenablereset": NativeFunction(lambda address: enable(address, is_on=False)),
    }
