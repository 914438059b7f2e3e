"""The words for AxisState and MC4State, which the controller and the drives show.

Source: manual 6066-6171; those that it does not give are of digest 3.2.
"""

from typing import Final

AXIS_WORDS: Final = {
    0: "hardware enable missing",
    1: "waiting for ControllerEnable",
    2: "releasing the brake",
    3: "under control",
    4: "stopping",
    5: "error",
}
_MC4_STATES: Final = {
    0x02: "stopped by an error",
    0x03: "hardware enable missing",
    0x10: "waiting for ControllerEnable",
    0x20: "releasing the brake",
    0x21: "under control",
    0x30: "overload stop",
    0x32: "held after an overload",
    0x40: "ramping down",
    0x41: "closing the brake",
    0x42: "coasting",
}
MC4_WORDS: Final = {state: f"(0x{state:02X}) {words}" for state, words in _MC4_STATES.items()}
"""Values of MC4State: those of `mc4.enable.Stage`, in hexadecimal as the manual has them, and in words."""
