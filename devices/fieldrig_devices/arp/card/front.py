"""The front of a card: what its state says, its terminals and its axes.

The manual shows no LEDs of the card; these four are ours, by its states (3.3) and the codes of errors and warnings (5).
"""

from collections.abc import Collection
from typing import Final

from fieldrig.front import Clamp, Front, Group, Key, Led, Number, Plate, Text
from fieldrig_devices.arp.card.local_io import ANALOG_INPUTS, ANALOG_OUTPUTS, DIGITAL_INPUTS, DIGITAL_OUTPUTS, ENCODERS
from fieldrig_devices.arp.user_port.wording import CODES

_DECIMALS: Final = 3
_CODES: Final = ((0, "none"), *((code, f"{text} ({code})") for code, text in CODES.items()))


def front_of(signals: Collection[str]) -> Front:
    """Return the front of a card; `signals` are the terminals whose wires the rig file names."""
    return Front(
        Plate("ASA-RT", "ARP", {"program": "program"}),
        [
            Group(
                [
                    Led("RUN", "state", "the program runs", lit=("run",), blinks=("stopped",)),
                    Led("ENABLE", "I108", "the input Enable"),
                    Led("ERROR", "error", "an error is pending", colour="red"),
                    Led("WARNING", "warning", "a warning is pending", colour="yellow"),
                    Text("state", "state", good=("run",), bad=("blocked",)),
                    Text("error", "error", "the last error", names=_CODES),
                    Text("warning", "warning", "the last warning", names=_CODES),
                    Text("program", "program.state"),
                    Number("line", "program.line", "line of the next instruction"),
                    Key("Run", "state", "starts the program", "run", pressed="run", released=None),
                    Key("Stop", "state", "stops the program", "stop", pressed="stop", released=None),
                    Key("Reset", "state", "resets the card", "reset", pressed="reset", released=None),
                ],
                "card",
            ),
            *(
                Group(
                    [
                        Number("position", f"axis{axis}.position", decimals=_DECIMALS),
                        Number("speed", f"axis{axis}.speed", decimals=_DECIMALS),
                        Number("tracking error", f"axis{axis}.error", decimals=_DECIMALS),
                    ],
                    f"axis {axis}",
                )
                for axis in (1, 2)
            ),
            Group([Clamp(name, name, is_set=name not in signals) for name in DIGITAL_INPUTS], "digital inputs"),
            Group([Clamp(name, name, side="out") for name in DIGITAL_OUTPUTS], "digital outputs"),
            Group(
                [
                    *(Clamp(name.upper(), name, is_set=name not in signals) for name in ANALOG_INPUTS),
                    *(Clamp(name.upper(), name) for name in ENCODERS),
                    *(Clamp(name.upper(), name, side="out") for name in ANALOG_OUTPUTS),
                ],
                "analog terminals and encoders",
            ),
        ],
    )
