"""S registers of a modem: what each sets, its unit, its default, and the values that it takes.

Source: ITU-T V.250 (S0, S3 to S8, S10), the Hayes command set for the others.  A register with "recorded" keeps its
value and does nothing, as initialization strings of drivers set it.
"""

from typing import Final, NamedTuple


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
