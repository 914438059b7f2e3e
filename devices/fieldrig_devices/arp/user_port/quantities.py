"""The values of the card that can be watched and traced: their names, where they are, and how they are written.

Names are those of the program, if it has one: V1, F3, I101, O101, @POS1, #VEL1, @PAR[5], @PAR1[7], @FLAG1, @OUT1,
#INP1, ERROR, WARNING.  The others are ours: TERR1 (tracking error), ADC1, DAC1, STATE, ERRORAXIS.  `@`, `#` and case
are ignored, and PAR.5 and PAR1.7 mean PAR[5] and PAR1[7], since shells interpret brackets.
"""

import re
from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from functools import partial
from typing import Final

from fieldrig.text.ranges import ranges
from fieldrig_devices.arp import fixed
from fieldrig_devices.arp.card_access import CardAccess, CardState
from fieldrig_devices.arp.language.instructions import numbers
from fieldrig_devices.arp.parameters import AXIS_PARAMETERS, GENERAL_PARAMETERS
from fieldrig_devices.arp.runtime import words
from fieldrig_devices.arp.user_port.messages import Quantity, RequestError, Status

AXES: Final = frozenset({1, 2})


class Kind(IntEnum):
    VARIABLE = ord("V")
    FLAG = ord("F")
    INPUT = ord("I")
    OUTPUT = ord("O")
    POSITION = ord("P")
    SPEED = ord("S")
    TRACKING_ERROR = ord("E")
    ANALOG_INPUT = ord("A")
    ANALOG_OUTPUT = ord("D")
    CONDITION = ord("C")
    GENERAL_PARAMETER = ord("G")
    PARAMETER_1 = ord("X")
    PARAMETER_2 = ord("Y")
    FLAG_WORD = ord("f")
    INPUT_WORD = ord("i")
    OUTPUT_WORD = ord("o")


BITS: Final = frozenset({Kind.FLAG, Kind.INPUT, Kind.OUTPUT})
GROUPS: Final[Mapping[int, int]] = {Kind.GENERAL_PARAMETER: 0, Kind.PARAMETER_1: 1, Kind.PARAMETER_2: 2}
STATE, ERROR, ERROR_AXIS, WARNING = range(4)
"""Numbers of the quantities of Kind.CONDITION."""

NUMBERS: Final[Mapping[int, frozenset[int]]] = {
    Kind.VARIABLE: numbers("V"),
    Kind.FLAG: numbers("F"),
    Kind.INPUT: numbers("I"),
    Kind.OUTPUT: numbers("O"),
    Kind.POSITION: AXES,
    Kind.SPEED: AXES,
    Kind.TRACKING_ERROR: AXES,
    Kind.ANALOG_INPUT: frozenset(range(1, 7)),
    Kind.ANALOG_OUTPUT: frozenset({1, 2}),
    Kind.CONDITION: frozenset(range(4)),
    Kind.GENERAL_PARAMETER: frozenset(GENERAL_PARAMETERS),
    Kind.PARAMETER_1: frozenset(AXIS_PARAMETERS),
    Kind.PARAMETER_2: frozenset(AXIS_PARAMETERS),
    Kind.FLAG_WORD: frozenset(range(1, 11)),
    Kind.INPUT_WORD: frozenset({1, 2, 3}),
    Kind.OUTPUT_WORD: frozenset({1, 2, 3}),
}
WORDS: Final = frozenset({Kind.FLAG_WORD, Kind.INPUT_WORD, Kind.OUTPUT_WORD})

# ---- on the card

_CONDITION: Final[dict[int, Callable[[CardAccess], int]]] = {
    STATE: lambda card: card.state,
    ERROR: lambda card: card.errors.error,
    ERROR_AXIS: lambda card: card.errors.error_axis,
    WARNING: lambda card: card.errors.warning,
}


def reader(card: CardAccess, wanted: Quantity) -> Callable[[], int]:
    """Return a function that reads the present raw value.  Raises RequestError for a quantity that does not exist."""
    kind, number = wanted
    if number not in NUMBERS.get(kind, ()):
        raise RequestError(Status.RANGE, f"there is no quantity {kind:02X}h {number}")
    match kind:
        case Kind.VARIABLE | Kind.FLAG | Kind.INPUT | Kind.OUTPUT:
            return partial(table(card, kind).__getitem__, number)
        case Kind.POSITION:
            return partial(card.position, number)
        case Kind.SPEED:
            return partial(card.speed, number)
        case Kind.TRACKING_ERROR:
            return partial(card.tracking_error, number)
        case Kind.ANALOG_INPUT:
            return partial(card.analog_input, number)
        case Kind.ANALOG_OUTPUT:
            return partial(card.analog_output, number)
        case Kind.CONDITION:
            return partial(_CONDITION[number], card)
        case Kind.FLAG_WORD:
            return partial(_word, card.F, 32 * number - 31)
        case Kind.INPUT_WORD:
            return partial(_word, card.I, 100 * number + 1)
        case Kind.OUTPUT_WORD:
            return partial(_word, card.O, 100 * number + 1)
        case _:
            return partial(card.parameters.ram[GROUPS[kind]].__getitem__, number)


def _word(bits: Sequence[int], first: int) -> int:
    return words.packed(bits[first : first + 32])


def table(card: CardAccess, kind: int) -> list[int]:
    """Table of V, F, I or O.  Raises RequestError for any other kind."""
    match kind:
        case Kind.VARIABLE:
            return card.V
        case Kind.FLAG:
            return card.F
        case Kind.INPUT:
            return card.I
        case Kind.OUTPUT:
            return card.O
    raise RequestError(Status.RANGE, f"there is no table {kind:02X}h")


# ---- for people

_KINDS: Final = {
    "V": Kind.VARIABLE,
    "F": Kind.FLAG,
    "I": Kind.INPUT,
    "O": Kind.OUTPUT,
    "POS": Kind.POSITION,
    "VEL": Kind.SPEED,
    "TERR": Kind.TRACKING_ERROR,
    "ADC": Kind.ANALOG_INPUT,
    "DAC": Kind.ANALOG_OUTPUT,
    "FLAG": Kind.FLAG_WORD,
    "INP": Kind.INPUT_WORD,
    "OUT": Kind.OUTPUT_WORD,
}
_WORDS: Final = {"STATE": STATE, "ERROR": ERROR, "ERRORAXIS": ERROR_AXIS, "WARNING": WARNING}
_SIGNS: Final = {
    Kind.POSITION: "@",
    Kind.SPEED: "#",
    Kind.FLAG_WORD: "@",
    Kind.INPUT_WORD: "#",
    Kind.OUTPUT_WORD: "@",
}
_PLAIN: Final = re.compile(rf"[@#]?({'|'.join(_KINDS)})\[?(\d{{1,4}})\]?", re.ASCII)
_PARAMETER: Final = re.compile(r"@?PAR([12]?)(?:\[(\d{1,2})\]|\.(\d{1,2}))", re.ASCII)

FORMS: Final = (
    "V1, F3, I101, O101, @POS1, #VEL1, TERR1, ADC1, DAC1, @PAR[5], @PAR1[7],"
    " @FLAG1, #INP1, @OUT1, STATE, ERROR, ERRORAXIS, WARNING"
)


def named(text: str) -> Quantity:
    """The quantity with this name.  Raises ValueError, which says what was expected, for an unknown name."""
    word = text.strip().upper()
    if word in _WORDS:
        return Quantity(Kind.CONDITION, _WORDS[word])
    if (match := _PARAMETER.fullmatch(word)) is not None:
        kind = {"": Kind.GENERAL_PARAMETER, "1": Kind.PARAMETER_1, "2": Kind.PARAMETER_2}[match[1]]
        return _within(text, kind, int(match[2] or match[3]))
    if (match := _PLAIN.fullmatch(word)) is not None:
        return _within(text, _KINDS[match[1]], int(match[2]))
    raise ValueError(f"{text!r} is not a value of the card\nexpected {FORMS}")


def _within(text: str, kind: Kind, number: int) -> Quantity:
    if number not in NUMBERS[kind]:
        raise ValueError(f"there is no {text.upper()}\nexpected {ranges(NUMBERS[kind])}")
    return Quantity(kind, number)


def name_of(quantity: Quantity) -> str:
    kind, number = Kind(quantity.kind), quantity.number
    if kind is Kind.CONDITION:
        return next(word for word, code in _WORDS.items() if code == number)
    if kind in GROUPS:
        return f"@PAR{GROUPS[kind] or ''}[{number}]"
    word = next(word for word, known in _KINDS.items() if known is kind)
    return f"{_SIGNS.get(kind, '')}{word}{number}"


def value_of(quantity: Quantity, raw: int) -> int | float | str:
    """Value as data; words of bits as unsigned 32-bit numbers."""
    if quantity == (Kind.CONDITION, STATE):
        return state_name(raw)
    if quantity.kind in WORDS:
        return raw & 0xFFFF_FFFF
    if quantity.kind in BITS or quantity.kind == Kind.CONDITION:
        return raw
    return raw // fixed.SCALE if raw % fixed.SCALE == 0 else raw / fixed.SCALE


def text_of(quantity: Quantity, raw: int) -> str:
    if quantity.kind in WORDS:
        return f"H{raw & 0xFFFF_FFFF:08X}"
    if quantity.kind in BITS or quantity.kind == Kind.CONDITION:
        return str(value_of(quantity, raw))
    return fixed.to_text(raw)


def state_name(code: int) -> str:
    try:
        return CardState(code).name
    except ValueError:
        return str(code)


def raw_of(quantity: Quantity, text: str) -> int:
    """Raw value of a text for a quantity.  Raises ValueError, which says what was expected, for an invalid text."""
    if quantity.kind not in BITS:
        try:
            return fixed.to_raw(text)
        except (ValueError, ZeroDivisionError) as cause:
            raise ValueError(
                f"{text!r} is not a value\nexpected -999999.999 to 999999.999, with at most three decimals"
            ) from cause
    bits = {"0": 0, "1": 1, "LO": 0, "HI": 1, "OFF": 0, "ON": 1}
    if text.upper() not in bits:
        raise ValueError(f"{text!r} is not a bit\nexpected 0 or 1")
    return bits[text.upper()]


def assigned(text: str) -> tuple[Quantity, int]:
    """Split `V1=2.5` into the quantity and its raw value.  Raises ValueError, which says what was expected."""
    name, sign, value = text.partition("=")
    if not sign:
        raise ValueError(f"{text!r} has no value\nexpected NAME=VALUE, such as V1=2.5")
    quantity = named(name)
    return quantity, raw_of(quantity, value.strip())
