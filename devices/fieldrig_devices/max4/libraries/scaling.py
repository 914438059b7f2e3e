"""ScalFollPos and its constants g_K_ (PD-189), and the constants of the set position modes.

ScalFollPos(m, sMasterPos, K) = (m * sMasterPos) / K is the height of a cam of the length sMasterPos whose slope at the
turning point is m, because K is the Cv of its motion law.  So cams with the same m join at the same speed.  In the
manual's program m is 1.0: the axis moves as far as the master.
"""

from math import copysign, inf, isnan
from typing import Final

from fieldrig_devices.iec.host import NativeFunction, Results
from fieldrig_devices.max4.libraries.track import Setpos
from fieldrig_devices.motion.curves.laws import LAWS

CONSTANTS: Final = "".join(f"    g_K_{law.constant} : LREAL := {law.cv!r};\n" for law in LAWS.values())
MODES: Final = "".join(f"    {mode.name} : INT := {mode.value};\n" for mode in Setpos)

TEXT: Final = f"""
VAR_GLOBAL CONSTANT
    (* Cv of the motion laws *)
{CONSTANTS}
    (* iXSetposMode and iYSetposMode *)
{MODES}END_VAR

FUNCTION ScalFollPos : LREAL
VAR_INPUT
    m : LREAL;              (* way of the axis for one unit of the master, at the turning point *)
    sMasterPos : LREAL;     (* length of the cam *)
    K : LREAL;              (* g_K_ of its motion law *)
END_VAR
{{native}}
END_FUNCTION
"""


def scal_foll_pos(m: float, length: float, k: float) -> Results:
    """Infinite or not a number where the arithmetic of IEEE 754 says so; CAM refuses such a factor."""
    way = m * length
    if k:
        return (way / k,)
    return (way if isnan(way) else copysign(inf, way * copysign(1.0, k)) if way else float("nan"),)


FUNCTIONS: Final = {"scalfollpos": NativeFunction(scal_foll_pos, cost_ns=1_000)}
