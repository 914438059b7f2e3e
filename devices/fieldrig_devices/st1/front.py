"""The front of an ST1: its state on the ring, its axis, and the terminals of its boards.

Source: tables 12-1 and 12-4 for the words of the axis, PAMS-110 for the terminals.  The manual shows no LEDs.
"""

from fieldrig.front import Clamp, Front, Group, Led, Number, Plate, Switch, Text
from fieldrig_devices.motion.front import motion, position, shaft
from fieldrig_devices.st1.settings import INPUTS, OUTPUTS, St1Settings

_DECIMALS = 4


def front_of(settings: St1Settings) -> Front:
    parameters = settings.parameters
    outputs = [Clamp(f"OUT{number}", f"OUT{number}", side="out") for number in OUTPUTS if settings.oio_board]
    return Front(
        Plate("Socapel", "ST1"),
        [
            Group(
                [
                    Text("node", "node", good=("running",)),
                    Text("fault of the ring", "ring", names=(("", "none"),)),
                    Led("power", "power", "the power stage is on"),
                    Led("error", "error", "a bit of the error word is set", colour="red"),
                    Text("errors", "errors", "names of the bits of the error word", names=(("", "none"),)),
                    Switch("enable", "enable", "the input that enables the power stage"),
                ],
                "state",
            ),
            motion(
                position(_DECIMALS, parameters.phil1, parameters.phil2),
                ("speed", parameters.ckv),
                ("torque", settings.motor.largest_torque_nm),
                shaft("motor", 1.0, "the motor"),
            ),
            Group(
                [
                    Number("lag", "lag", "from the shaft to the set position", decimals=_DECIMALS),
                    Number("torque limit", "torque_limit", "by a pipe", decimals=0),
                    Number("supply", "supply", "UA", decimals=0),
                    Number("motor", "motor_temperature", "temperature of the motor", decimals=1),
                ],
                "measured",
            ),
            Group([_input(f"IN{number}", settings) for number in INPUTS], "inputs"),
            *([Group(outputs, "outputs")] if outputs else []),
        ],
    )


def _input(terminal: str, settings: St1Settings) -> Clamp:
    return Clamp(terminal, terminal, is_set=terminal not in settings.terminals)
