"""The front of a modem: the row of LEDs that external modems have, and the line of the call.

The letters are the usual ones of external modems, whose manuals name them after the circuits of V.24.
"""

from typing import Final

from fieldrig.front import Front, Group, Led, Number, Plate, Text
from fieldrig_devices.modem.call import CallState

_OFF_HOOK: Final = tuple(state.value for state in CallState if state is not CallState.IDLE)
FRONT: Final = Front(
    Plate("", "modem"),
    [
        Group(
            [
                Led("MR", "dsr", "modem ready (DSR)"),
                Led("TR", "dtr", "terminal ready (DTR)"),
                Led("OH", "call", "off hook: it has the line", lit=_OFF_HOOK),
                Led("CD", "dcd", "a carrier (DCD)"),
                Led("SD", "sd", "the terminal sends data", colour="yellow"),
                Led("RD", "rd", "the terminal receives data", colour="yellow"),
                Led("RI", "ri", "it rings (RI)", colour="yellow"),
                Led("RS", "rts", "the modem may send (RTS)"),
                Led("CS", "cts", "the terminal may send (CTS)"),
                Led("EC", "corrected", "errors are corrected"),
            ],
            "LEDs",
        ),
        Group(
            [
                Text("mode", "mode", bad=("off",)),
                Text("call", "call", good=(CallState.CONNECTED.value,)),
                Number("rate", "rate", "of the call"),
                Text("modulation", "modulation", names=(("", "none"),)),
                Number("rings", "rings", "register S1"),
                Number("serial line", "baud"),
            ],
            "call",
        ),
    ],
)
