"""The front of a PAM: the display of eight characters, the green LED and the button for a reset.

Source: chapter 11 for the display, tables 12-8 to 12-10 for the LED.
"""

from collections.abc import Iterable

from fieldrig.front import Clamp, Front, Group, Key, Led, Lines, Number, Plate, Text
from fieldrig_devices.pam.panel.display import DIGITS


def front_of(analog_outputs: Iterable[int]) -> Front:
    """Return the front of a PAM with these analog outputs."""
    outputs = [Clamp(f"analog {address}", f"analog.{address}", side="out") for address in analog_outputs]
    return Front(
        Plate("Socapel", "PAM"),
        [
            Group(
                [
                    Lines("display", "display", "the display", columns=DIGITS, blinks="display.blinks"),
                    Led(
                        "PAM",
                        "led",
                        "it blinks after an error of the kernel",
                        lit=("on",),
                        blinks=("blink",),
                    ),
                    Key("Reset", "reset", "a hardware reset", released=None),
                ],
                "panel",
            ),
            Group(
                [
                    Text("state", "state", good=("running",), bad=("fatal",)),
                    Text("ring", "ring", good=("running",)),
                    Number("cycles", "cycle", "basic cycles since power-on"),
                    Text("fault", "fault", "why the application has stopped", names=(("", "none"),)),
                    Text("errors", "errors", "the error list", names=(("", "none"),)),
                    Text("messages", "messages", "what the debugger printed last", names=(("", "none"),)),
                ],
                "application",
            ),
            *([Group(outputs, "analog outputs")] if outputs else []),
        ],
    )
