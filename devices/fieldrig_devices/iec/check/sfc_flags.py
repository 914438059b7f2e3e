"""The variables by which a program steers its charts: SFCInit, SFCReset, SFCPause and others, if it declares them.

Source: the public descriptions of CoDeSys V2.3, CODESYS V3 and TwinCAT 3.  What belongs to the time limits of steps
(SFCError, SFCEnableLimit, SFCErrorStep, SFCErrorPOU, SFCQuitError) is left out, because texts have no such limits.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import Variable
from fieldrig_devices.iec.tree import Name
from fieldrig_devices.iec.types import StringType

INIT: Final = "SFCInit"
"""The chart is at its initial step, without running it, as long as this is TRUE."""
RESET: Final = "SFCReset"
"""The same, but the initial step runs."""
PAUSE: Final = "SFCPause"
"""Nothing of the chart runs."""
FIRED: Final = "SFCTrans"
"""A transition has fired in the last cycle."""
STEP: Final = "SFCCurrentStep"
"""The name of the active step; of several, the last one."""
TIP_MODE: Final = "SFCTipMode"
"""A transition fires when SFCTip becomes TRUE, and not by its condition."""
TIP: Final = "SFCTip"

Flags = Mapping[str, Name]


def declared_flags(context: Context) -> Flags:
    """Return those that are known in the POU of a chart, by their names."""
    if not context.project.dialect.has_chart_flags:
        return {}
    found: dict[str, Name] = {}
    for name in (INIT, RESET, PAUSE, FIRED, TIP_MODE, TIP, STEP):
        entity = context.find(name)
        wanted = isinstance(entity, Variable) and (
            isinstance(entity.type, StringType) if name == STEP else entity.type is Elementary.BOOL
        )
        if wanted and not (isinstance(entity, Variable) and entity.is_constant):
            found[name] = Name(name)
    return found if TIP in found else {name: one for name, one in found.items() if name != TIP_MODE}


def any_of(flags: Flags, *names: str) -> tree.Expression | None:
    """Return the expression that one of these is TRUE; None if the program has none of them."""
    joined: tree.Expression | None = None
    for name in names:
        if name in flags:
            joined = flags[name] if joined is None else tree.Binary("OR", joined, flags[name])
    return joined
