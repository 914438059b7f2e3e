"""The objects of the card by index and sub-index, and what each stands for.

Source: ours (docs/arp-can.md), in the manufacturer's area of CiA 301; digest chapter 20 names what is wanted.  Values
are raw integers, value x 1000, as programs see them; words of flags, inputs and outputs are bits.
"""

from typing import Final

VARIABLES: Final = 0x2000
"""And the three after it: V1 to V250, V251 to V500, ..."""
VARIABLES_IN_OBJECT: Final = 250
FLAG_WORDS, OUTPUT_WORDS, INPUT_WORDS = 0x2010, 0x2011, 0x2012
ANALOG_INPUTS, ANALOG_OUTPUTS = 0x2020, 0x2021
COMMAND, CONTROL, STATE, ERROR, WARNING, ERROR_AXIS, PROGRAM_NAME, CARD_NUMBER = range(0x2100, 0x2108)
POSITIONS, SPEEDS, TRACKING_ERRORS, AXIS_FLAGS = range(0x2200, 0x2204)
PARAMETERS: Final = (0x2300, 0x2301, 0x2302)
"""General ones, those of axis 1, those of axis 2; the sub-index is the number."""

WORDS: Final = {"V": 1000, "FLAG": 10, "OUT": 3, "INP": 3, "POS": 2, "VEL": 2}
"""How many there are of what programs name so."""
_INDEX: Final = {"FLAG": FLAG_WORDS, "OUT": OUTPUT_WORDS, "INP": INPUT_WORDS, "POS": POSITIONS, "VEL": SPEEDS}


def place(what: str, number: int) -> tuple[int, int]:
    """Index and sub-index of one of `WORDS`, which has 32 bits."""
    if what == "V":
        block, offset = divmod(number - 1, VARIABLES_IN_OBJECT)
        return VARIABLES + block, offset + 1
    return _INDEX[what], number
