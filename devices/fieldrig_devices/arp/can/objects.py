"""The objects of the card by index and sub-index: what each reads, and what a write to it does.

Source: ours (docs/devices/arp/arp-can.md), in the manufacturer-specific area of CiA 301; digest chapter 20 lists the
requirements. Values are raw integers, value x 1000, as programs see them; words of flags, inputs and outputs are bits.
The card determines which bits of flag words are writable, and when outputs are (`CardAccess`).
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Final

from fieldrig_devices.arp.card_access import CardAccess
from fieldrig_devices.arp.fixed import SCALE
from fieldrig_devices.arp.parameters import PARAMETERS
from fieldrig_devices.arp.runtime.words import packed
from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.canopen.live import text_bytes
from fieldrig_devices.canopen.signals import SignalSettings

VARIABLES: Final = 0x2000
"""Index of V1 to V250; the next three indices have V251 to V1000."""
VARIABLES_IN_OBJECT: Final = 250
FLAG_WORDS, OUTPUT_WORDS, INPUT_WORDS = 0x2010, 0x2011, 0x2012
ANALOG_INPUTS, ANALOG_OUTPUTS = 0x2020, 0x2021
COMMAND, CONTROL, STATE, ERROR, WARNING, ERROR_AXIS, PROGRAM_NAME, CARD_NUMBER = range(0x2100, 0x2108)
POSITIONS, SPEEDS, TRACKING_ERRORS, AXIS_FLAGS = range(0x2200, 0x2204)
GROUPS: Final = (0x2300, 0x2301, 0x2302)
"""Indices of the general parameters and those of axis 1 and 2; the sub-index is the parameter's number."""

WORDS: Final = {"V": 1000, "FLAG": 10, "OUT": 3, "INP": 3, "POS": 2, "VEL": 2}
"""Number of words for each name that programs use."""
NUMBERS: Final = ("V", "POS", "VEL")
"""The words that are numbers; the others are sets of bits."""
_INDEX: Final = {"FLAG": FLAG_WORDS, "OUT": OUTPUT_WORDS, "INP": INPUT_WORDS, "POS": POSITIONS, "VEL": SPEEDS}

AXES: Final = (1, 2)
AXIS_FLAG_WORD: Final = {1: 9, 2: 10}
BITS: Final = 32
LOWEST, HIGHEST = -(1 << 31), (1 << 31) - 1


Read = Callable[[], bytes]
Write = Callable[[bytes], None]
"""Takes data of the correct size, within the limits of the EDS.  Raises Abort if the card refuses them."""


@dataclass(frozen=True, slots=True)
class Cell:
    """Read and write functions of one object."""

    index: int
    subindex: int
    read: Read
    write: Write | None = None


def place(what: str, number: int) -> tuple[int, int]:
    """Index and sub-index of one of `WORDS`, which has 32 bits."""
    if what == "V":
        block, offset = divmod(number - 1, VARIABLES_IN_OBJECT)
        return VARIABLES + block, offset + 1
    return _INDEX[what], number


def signals() -> dict[str, SignalSettings]:
    """Return the words of programs by object, for tools; a number is 1000 times the value."""
    return {
        "{:04X}:{:02X}".format(*place(what, number)): SignalSettings(
            wire=f"{what}{number}", scale=1 / SCALE if what in NUMBERS else 1.0
        )
        for what, count in WORDS.items()
        for number in range(1, count + 1)
    }


def cells(card: CardAccess) -> Iterator[Cell]:
    """Cells for all objects that mirror the card; `control` has the commands."""
    yield from _variables(card)
    yield from _words(card)
    yield from _axes(card)
    yield from _signals(card)
    yield from _parameters(card)
    yield Cell(STATE, 0, lambda: _unsigned(card.state, 1))
    yield Cell(ERROR, 0, lambda: _unsigned(card.errors.error, 2))
    yield Cell(WARNING, 0, lambda: _unsigned(card.errors.warning, 2))
    yield Cell(ERROR_AXIS, 0, lambda: _unsigned(card.errors.error_axis, 1))
    yield Cell(PROGRAM_NAME, 0, lambda: text_bytes(card.program_name))
    yield Cell(CARD_NUMBER, 0, lambda: _unsigned(card.number, 1))


def _variables(card: CardAccess) -> Iterator[Cell]:
    for number in range(1, WORDS["V"] + 1):
        yield Cell(*place("V", number), partial(_element, card.V, number), partial(_set_variable, card, number))


def _words(card: CardAccess) -> Iterator[Cell]:
    for number in range(1, WORDS["FLAG"] + 1):
        first = first_flag(number)
        yield Cell(FLAG_WORDS, number, partial(_word, card.F, first), partial(_set_flags, card, first))
    for number in range(1, WORDS["OUT"] + 1):
        first = 100 * number + 1
        yield Cell(OUTPUT_WORDS, number, partial(_word, card.O, first), partial(_set_outputs, card, first))
        yield Cell(INPUT_WORDS, number, partial(_word, card.I, first))


def _axes(card: CardAccess) -> Iterator[Cell]:
    for axis in AXES:
        yield Cell(POSITIONS, axis, partial(_asked, card.position, axis))
        yield Cell(SPEEDS, axis, partial(_asked, card.speed, axis))
        yield Cell(TRACKING_ERRORS, axis, partial(_asked, card.tracking_error, axis))
        yield Cell(AXIS_FLAGS, axis, partial(_word, card.F, first_flag(AXIS_FLAG_WORD[axis])))


def _signals(card: CardAccess) -> Iterator[Cell]:
    for channel in range(1, 7):
        yield Cell(ANALOG_INPUTS, channel, partial(_asked, card.analog_input, channel))
    for channel in (1, 2):
        yield Cell(ANALOG_OUTPUTS, channel, partial(_asked, card.analog_output, channel))


def _parameters(card: CardAccess) -> Iterator[Cell]:
    for group, index in enumerate(GROUPS):
        for number in PARAMETERS[group]:
            read = partial(_element, card.parameters.ram[group], number)
            yield Cell(index, number, read, partial(_set_parameter, card, group, number))


def first_flag(word: int) -> int:
    return BITS * (word - 1) + 1


def _asked(ask: Callable[[int], int], number: int) -> bytes:
    """Value that the card computes on request, limited to 32 bits."""
    return min(max(ask(number), LOWEST), HIGHEST).to_bytes(4, "little", signed=True)


def _unsigned(number: int, size: int) -> bytes:
    return number.to_bytes(size, "little")


def _element(table: Sequence[int], number: int) -> bytes:
    return table[number].to_bytes(4, "little", signed=True)


def _word(bits: Sequence[int], first: int) -> bytes:
    return packed(bits[first : first + BITS]).to_bytes(4, "little", signed=True)


def _set_variable(card: CardAccess, number: int, data: bytes) -> None:
    if not card.set_variables(number, (int.from_bytes(data, "little", signed=True),)):
        raise Abort(Code.INVALID_VALUE)


def _set_flags(card: CardAccess, first: int, data: bytes) -> None:
    for number, bit in _changes(card.F, first, data):
        card.set_flag(number, bit)  # digest chapter 7: writes to read-only bits are dropped


def _set_outputs(card: CardAccess, first: int, data: bytes) -> None:
    for number, bit in _changes(card.O, first, data):
        if not card.set_output(number, bit):
            raise Abort(Code.DEVICE_STATE)


def _changes(bits: Sequence[int], first: int, data: bytes) -> Iterator[tuple[int, int]]:
    """Number and new value of each bit that `data` changes."""
    wanted = int.from_bytes(data, "little")
    changed = wanted ^ int.from_bytes(_word(bits, first), "little")
    while changed:
        lowest = changed & -changed
        yield first + lowest.bit_length() - 1, int(bool(wanted & lowest))
        changed ^= lowest


def _set_parameter(card: CardAccess, group: int, number: int, data: bytes) -> None:
    raw = int.from_bytes(data, "little", signed=True)
    if not card.parameters.takes(group, number, raw):
        raise Abort(Code.INVALID_VALUE)
    if not card.set_parameter(group, number, raw):
        raise Abort(Code.DEVICE_STATE)
