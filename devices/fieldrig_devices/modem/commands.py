"""The basic AT commands and the S registers of a modem, a row each: its values, and what each of them means.

Source: ITU-T V.250 (registers S0, S3 to S8, S10), and the manual for `&C`, `&F`, `&R`, `&S` (PD-248); the others as the
usual chip sets and the Hayes command set have them.  Commands that dial (D), and S registers, have a syntax of their
own.  A setting or register with "recorded" keeps its value and does nothing, as there is no loudspeaker and no leased
line, and initialization strings of drivers set it.
"""

from collections.abc import Mapping
from typing import Final, NamedTuple


class Command(NamedTuple):
    values: Mapping[int, str]
    """Meanings by value; the value 0 may be left out."""
    default: int | None = None
    """The factory default of a setting, which profiles keep; None for an action."""


COMMANDS: Final[dict[str, Command]] = {
    "A": Command({0: "answer"}),
    "B": Command({0: "recorded: ITU-T below 2400 bit/s", 1: "recorded: Bell below 2400 bit/s"}, 0),
    "E": Command({0: "echo off", 1: "echo on"}, 1),
    "H": Command({0: "hang up", 1: "seize the line"}),
    "I": Command(dict.fromkeys(range(10), "information text")),
    "L": Command(dict.fromkeys(range(4), "recorded: volume"), 1),
    "M": Command(dict.fromkeys(range(4), "recorded: loudspeaker"), 1),
    "N": Command({0: "only the modulation of +MS", 1: "slower modulations as well"}, 1),
    "O": Command({0: "back to the call", 1: "back to the call, with a retrain"}),
    "P": Command({0: "dial by pulses"}),
    "Q": Command({0: "result codes", 1: "no result codes", 2: "result codes of own calls only"}, 0),
    "T": Command({0: "dial by tones"}),
    "V": Command({0: "numeric result codes", 1: "verbose result codes"}, 1),
    "W": Command(
        {0: "CONNECT with the rate of the serial line", 1: "carrier, protocol and CONNECT", 2: "CONNECT with the rate "
         "of the telephone line"}, 2,
    ),
    "X": Command(
        {0: "CONNECT without rate, blind dialling, no busy tone", 1: "blind dialling, no busy tone",
         2: "waits for the dial tone, no busy tone", 3: "blind dialling, detects busy", 4: "dial tone and busy"}, 4,
    ),
    "Y": Command({0: "recorded: long space disconnect", 1: "recorded: long space disconnect"}, 0),
    "Z": Command({0: "reset to stored profile 0", 1: "reset to stored profile 1"}),
    "&C": Command({0: "DCD is always on", 1: "DCD follows the carrier"}, 1),
    "&D": Command(
        {0: "DTR is ignored", 1: "DTR off: command state", 2: "DTR off: hang up", 3: "DTR off: hang up and reset"}, 2,
    ),
    "&F": Command({0: "factory defaults", 1: "factory defaults"}),
    "&G": Command(dict.fromkeys(range(3), "recorded: guard tone"), 0),
    "&J": Command({0: "recorded: jack", 1: "recorded: jack"}, 0),
    "&K": Command({0: "no flow control", 3: "RTS and CTS", 4: "XON and XOFF"}, 3),
    "&L": Command({0: "recorded: dialled line"}, 0),
    "&M": Command({0: "recorded: asynchronous"}, 0),
    "&P": Command(dict.fromkeys(range(4), "recorded: make and break of pulses"), 0),
    "&Q": Command({0: "recorded: asynchronous", 5: "recorded: error control", 6: "recorded: speed buffering"}, 5),
    "&R": Command({0: "RTS and CTS are obeyed and driven as &K says", 1: "CTS is always on, RTS is ignored"}, 0),
    "&S": Command({0: "DSR is always on", 1: "DSR is on during calls"}, 0),
    "&T": Command({0: "end a test", 4: "recorded: remote loop granted", 5: "recorded: remote loop refused"}, 4),
    "&V": Command({0: "show profiles and numbers"}),
    "&W": Command({0: "store profile 0", 1: "store profile 1"}),
    "&X": Command({0: "recorded: internal clock"}, 0),
    "&Y": Command({0: "profile 0 at power-on", 1: "profile 1 at power-on"}),
    "\\A": Command(dict.fromkeys(range(4), "recorded: largest MNP block"), 1),
    "\\B": Command(dict.fromkeys(range(10), "recorded: break"), 3),
    "\\G": Command({0: "recorded: flow control at the line", 1: "recorded: flow control at the line"}, 0),
    "\\J": Command({0: "recorded: serial rate is kept", 1: "recorded: serial rate follows the line"}, 0),
    "\\K": Command(dict.fromkeys(range(6), "recorded: break"), 5),
    "\\N": Command(
        {0: "no error correction", 1: "no error correction", 2: "error correction, or no call",
         3: "error correction if possible", 4: "error correction, or no call", 5: "error correction if possible"}, 3,
    ),
    "\\Q": Command({0: "recorded: flow control", 1: "recorded: flow control", 3: "recorded: flow control"}, 3),
    "\\V": Command({0: "recorded: protocol in results", 1: "recorded: protocol in results"}, 0),
    "%C": Command(dict.fromkeys(range(4), "recorded: compression"), 3),
    "%E": Command(dict.fromkeys(range(3), "recorded: retrain and fallback"), 2),
}  # fmt: skip
"""Commands by name.  A value that a row does not have is an error."""


class Register(NamedTuple):
    default: int
    low: int
    high: int
    meaning: str
    is_kept: bool = True
    """It is in the profiles that &W stores."""


REGISTERS: Final[dict[int, Register]] = {
    0: Register(0, 0, 255, "ring after which the modem answers; 0: it does not"),
    1: Register(0, 0, 255, "rings so far; 0 after 8 s without a ring", False),
    2: Register(43, 0, 255, "character of the escape sequence; above 127: none"),
    3: Register(13, 0, 127, "character that ends a command line"),
    4: Register(10, 0, 127, "character after it in answers"),
    5: Register(8, 0, 127, "character that deletes the last one"),
    6: Register(2, 2, 255, "s before blind dialling"),
    7: Register(50, 1, 255, "s from the last digit, or the answer, to the carrier"),
    8: Register(2, 0, 255, "s of a comma in a dial string"),
    9: Register(6, 1, 255, "recorded"),
    10: Register(14, 1, 255, "0.1 s without a carrier after which the modem hangs up; 255: never"),
    11: Register(95, 50, 255, "ms of a dial tone, and of the pause after it"),
    12: Register(50, 0, 255, "0.02 s of silence around the escape sequence"),
    25: Register(5, 0, 255, "0.01 s for which DTR must be off"),
    30: Register(0, 0, 255, "10 s without data after which the modem hangs up; 0: never"),
    36: Register(7, 0, 255, "recorded"),
    37: Register(0, 0, 255, "recorded"),
    38: Register(20, 0, 255, "recorded"),
    46: Register(138, 0, 255, "recorded"),
    48: Register(7, 0, 255, "recorded"),
    95: Register(0, 0, 255, "recorded"),
}
