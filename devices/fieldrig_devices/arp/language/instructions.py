"""Table of the instructions that are a word and its values: the order and range of the values.

Source: manual 5.4 to 5.12; digest chapter 5.  The parser counts and reads values by this table, the checker compares
constants with their ranges, and the generator calls the function named after the word.  Values that a program computes
are checked at run time (`runtime.instructions`), with W03.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final


class Value(Enum):
    """Kind of value that an instruction accepts in one position; the text is its name in messages."""

    AXIS = "an axis, 1 or 2"
    CELL = "a load cell, 1 or 2"
    OUTPUT_CHANNEL = "an analog output, 1 or 2"
    TIMER = "a timer, 1 to 6"
    NUMBER = "a number or a variable"
    VARIABLE = "a variable V"
    FLAG = "a flag F"
    BIT = "a flag F or an output O"
    CAM_BIT = "an output O or a flag F, with ! before it if inverted"
    LINE = "a line, 1 to 8"
    COLUMN = "a column, 1 to 16"
    HEIGHT = "a height, 1 to 3"
    MESSAGE_NUMBER = "a message, 1 to 500"
    MESSAGE = "a message, 1 to 500, or a variable V"
    PRINTED = "a message, 0 to 500, or a variable V"
    TEXT = 'a string in "quotes"'
    MODE = "E or P"


CONSTANT: Final = {
    Value.AXIS: (1, 2),
    Value.CELL: (1, 2),
    Value.OUTPUT_CHANNEL: (1, 2),
    Value.TIMER: (1, 6),
    Value.LINE: (1, 8),
    Value.COLUMN: (1, 16),
    Value.HEIGHT: (1, 3),
    Value.MESSAGE_NUMBER: (1, 500),
    Value.MESSAGE: (1, 500),
    Value.PRINTED: (0, 500),
}
"""Ranges of the values that must be constants."""

OR_VARIABLE: Final = frozenset({Value.MESSAGE, Value.PRINTED})


@dataclass(frozen=True, slots=True)
class Signature:
    word: str
    values: tuple[Value, ...] = ()
    counts: tuple[int, ...] = ()
    """Permitted numbers of values; empty if all values are required."""

    def takes(self, count: int) -> bool:
        return count in (self.counts or (len(self.values),))

    def __str__(self) -> str:
        if not self.values:
            return f"{self.word} alone"
        counts = self.counts or (len(self.values),)
        values = f"{' or '.join(map(str, counts))} {'value' if counts == (1,) else 'values'}"
        return f"{self.word} with {values}: {'; '.join(value.value for value in self.values)}"


_POSITION = (Value.LINE, Value.COLUMN)

SIGNATURES: Final = {
    signature.word: signature
    for signature in (
        Signature("ON", (), (0,)),  # bare ONn; with values it has its own syntax
        Signature("CAM", (Value.AXIS, Value.NUMBER, Value.NUMBER, Value.CAM_BIT), (0, 4)),
        Signature("DAC", (Value.OUTPUT_CHANNEL, Value.NUMBER, Value.NUMBER), (2, 3)),
        Signature("HOME", (Value.AXIS,)),
        Signature("VEL", (Value.AXIS, Value.NUMBER)),
        Signature("ACC", (Value.AXIS, Value.NUMBER)),
        Signature("DEC", (Value.AXIS, Value.NUMBER)),
        Signature("PAC", (Value.AXIS, Value.NUMBER)),
        Signature("PRC", (Value.AXIS, Value.NUMBER)),
        Signature("PVC", (Value.AXIS, Value.NUMBER)),
        Signature("PST", (Value.AXIS, Value.AXIS, Value.VARIABLE)),
        Signature("STOP", (Value.AXIS,)),
        Signature("PID", (Value.CELL, Value.OUTPUT_CHANNEL, Value.VARIABLE)),
        Signature("WAIT", (Value.NUMBER,)),
        Signature("STIM", (Value.TIMER, Value.NUMBER, Value.FLAG), (1, 3)),
        Signature("SET", (Value.BIT,)),
        Signature("RES", (Value.BIT,)),
        Signature("MSG", (Value.MESSAGE_NUMBER, Value.TEXT)),
        Signature("TERM", (*_POSITION, Value.HEIGHT, Value.MESSAGE, Value.VARIABLE, Value.MODE), (0, 2, 4, 5, 6)),
        Signature("PRINT", (Value.PRINTED, Value.VARIABLE), (1, 2)),
    )
}

MOVES: Final = {"PAC": 0, "PRC": 0, "PVC": 0, "PST": 1}
"""Movements, which hold the program while their axis is busy (manual 5.9.3), and the position of the axis among their
values."""

READS: Final = {"ADC": (1, 6), "TIM": (1, 6), "ERROR": None, "WARNING": None}
"""Words that may only follow `==` by themselves, with the range of their number."""

CONSTANTS: Final = {"PIG": 3_142, "HI": 1_000, "ON": 1_000, "LO": 0, "OFF": 0}
FUNCTIONS: Final = ("SQR", "INT", "SEN", "COS")
ORGANISATION: Final = ("BEG", "END", "BEGA", "ENDA", "EQU", "GOTO", "CALL", "IF")
KEYWORDS: Final = frozenset({*SIGNATURES, *READS, *CONSTANTS, *FUNCTIONS, *ORGANISATION})

SYSTEM: Final = {
    "@POS": (1, 2),
    "#VEL": (1, 2),
    "#LQOSP": (1, 2),
    "#LQOSN": (1, 2),
    "@FLAG": (1, 10),
    "@OUT": (1, 3),
    "#INP": (1, 3),
}
"""System variables with the range of the number that is written directly after the name; @PAR is not among them."""

GENERAL_PARAMETERS: Final = 16
AXIS_PARAMETERS: Final = 25

_BLOCKS = ((101, 132), (201, 232), (301, 332))
RANGES: Final = {"V": ((1, 1000),), "F": ((1, 320),), "I": _BLOCKS, "O": _BLOCKS}
"""Resources and the ranges of their numbers; outputs above O104 without a terminal are memory bits."""

AXIS_FLAGS: Final = (257, 289)  # the first flag of each axis
WRITABLE: Final = frozenset(
    {*range(1, 257), *(first + offset for first in AXIS_FLAGS for offset in (5, 8, 9, 10, 11, 14, 15))}
)
"""Flags that a program may write (manual 4.4 to 4.6, 5.8.1).  Without a terminal, F218 to F256 are user flags too."""


def numbers(letter: str) -> frozenset[int]:
    return frozenset(number for first, last in RANGES[letter] for number in range(first, last + 1))
