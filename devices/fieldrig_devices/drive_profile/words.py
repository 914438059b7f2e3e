"""The meaning of the numbers in the objects of a drive: states, commands, modes and errors.

Source: CiA 402-2 (IEC 61800-7-201), tables of status word, control word, modes of operation and error codes.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig_devices.drive_profile.errors import DRIVE_ERRORS
from fieldrig_devices.drive_profile.objects import of_first_axis
from fieldrig_devices.drive_profile.states import FAULT_RESET, State, command_of

MODES: Final[Mapping[int, str]] = {
    0: "no mode", 1: "profile position", 2: "velocity", 3: "profile velocity", 4: "profile torque", 6: "homing",
    7: "interpolated position", 8: "cyclic synchronous position", 9: "cyclic synchronous velocity",
    10: "cyclic synchronous torque",
}  # fmt: skip
STATE_BITS: Final = 0x6F
WITHOUT_QUICK_STOP: Final = 0x4F
"""The bits of the states in which bit 5, quick stop, means nothing."""
_STATES: Final = {state.value: state.name.lower().replace("_", " ") for state in State}
HALT: Final = 0x100


def state_words(status_word: int) -> str:
    """Return the state of a status word, such as `operation enabled`; "" for bits that are no state."""
    return _STATES.get(status_word & STATE_BITS) or _STATES.get(status_word & WITHOUT_QUICK_STOP, "")


def command_words(control_word: int) -> str:
    """Return the command of a control word, such as `enable operation`, with `halt` if that bit is set."""
    if control_word & FAULT_RESET:
        return "fault reset"
    command = command_of(control_word)
    words = "" if command is None else command.name.lower().replace("_", " ")
    return f"{words}, halt" if words and control_word & HALT else words


def mode_words(mode: int) -> str:
    """Return the name of a mode of operation, which has a sign; "" for one of the maker."""
    return MODES.get(mode, "")


def error_words(code: int) -> str:
    """Return the meaning of an error code; "" for one of the maker."""
    return DRIVE_ERRORS.get(code, "")


# By index of the first axis: a word of the object's name, since other profiles have other objects there.
_MEANINGS: Final[Mapping[int, tuple[str, Callable[[int], str]]]] = {
    0x603F: ("error", error_words),
    0x6040: ("control", command_words),
    0x6041: ("status", state_words),
    0x6060: ("mode", mode_words),
    0x6061: ("mode", mode_words),
}


def meaning_of(index: int, name: str) -> Callable[[int], str] | None:
    """Return the meaning of the numbers of an object, by its index and its name in the EDS; None if they have none."""
    word, words = _MEANINGS.get(of_first_axis(index) or 0, ("", None))
    return words if word and word in name.lower() else None
