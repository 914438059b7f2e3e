"""The signals of an object that a PDO carries: its name, unit and limits, and the states, modes and bits in it.

Source: CiA 402-2 and 402-3 (status word, control word, modes of operation, units); CiA 301 version 4.2, table 26 (error
codes).  Units of position and speed are the user's; they are increments only if the factor group of the node says so.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Final, NamedTuple

from fieldrig_devices.canopen.bit_names import CONTROLWORD, STATUSWORD, bits_of
from fieldrig_devices.canopen.datatypes import Integer, Real
from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.emcy_words import ERROR_CLASSES, ERROR_CODES, is_drive
from fieldrig_devices.canopen.parts import object_key
from fieldrig_devices.canopen.signals import Binding
from fieldrig_devices.canopen.variable import Variable
from fieldrig_devices.drive_profile.errors import DRIVE_ERRORS
from fieldrig_devices.drive_profile.objects import of_first_axis
from fieldrig_devices.drive_profile.words import (
    MODES,
    command_words,
    error_words,
    meaning_of,
    mode_words,
    state_words,
)
from fieldrig_devices.export.network import NO_CHOICES, Signal

ERROR_NAMES: Final = {**{code << 8: name for code, name in ERROR_CLASSES.items()}, **ERROR_CODES}
ERROR_NAMES_OF_DRIVES: Final = {**ERROR_NAMES, **DRIVE_ERRORS}
STATE_BITS, COMMAND_BITS = 7, 4
PERCENT: Final = (0.1, "%")
POSITIONS: Final = (0x6062, 0x6063, 0x6064, 0x6065, 0x6067, 0x607A, 0x607C, 0x60F4, 0x60FC)
SPEEDS: Final = (0x606B, 0x606C, 0x6081, 0x60FF)
FIXED: Final = {
    **dict.fromkeys((0x6071, 0x6072, 0x6073, 0x6074, 0x6077, 0x6078), PERCENT),  # of the rated torque or current
    0x6075: (0.001, "A"), 0x6076: (0.001, "N m"), 0x6079: (0.001, "V"),
}  # fmt: skip
"""Scale and unit of objects that have one by the standard."""
WORD: Final = re.compile(r"(?:status|control)\s?word", re.IGNORECASE)
RESOLUTION, GEAR, FEED = 0x608F, 0x6091, 0x6092


class _Quantity(NamedTuple):
    scale: float = 1.0
    unit: str = ""


@dataclass(frozen=True, slots=True)
class Objects:
    """The objects of one node, and the wires that the rig file connects to them."""

    dictionary: Dictionary
    bindings: tuple[Binding, ...] = ()

    def signals(self, index: int, subindex: int, start: int, length: int) -> Iterator[Signal]:
        """Yield the signals of what is mapped at bit `start` over `length` bits; none for a dummy."""
        variable = self.dictionary.get(index, subindex)
        if variable is None:
            return
        about = f"{object_key(index, subindex)} {variable.name}"
        if not isinstance(variable.type, Integer) or variable.type.bits != length:
            is_float = isinstance(variable.type, Real) and variable.type.bits == length
            yield self._measured(Signal(variable.name, start, length, is_float=is_float, about=about), variable)
            return
        for signal in self._parts(variable, length):
            yield replace(signal, start=start + signal.start, about=about)

    def _parts(self, variable: Variable, length: int) -> Iterable[Signal]:
        """Return the signals of a number, whose bits count from 0."""
        words, wires = bits_of(variable), self._wires_of_bits(variable)
        if words is STATUSWORD:
            state = Signal(f"{variable.name} state", 0, STATE_BITS, choices=STATES)
            return (state, *_bits(variable.name, _of_axis(variable, words), STATE_BITS, length))
        if words is CONTROLWORD:
            command = Signal(f"{variable.name} command", 0, COMMAND_BITS, choices=COMMAND_NAMES)
            return (command, *_bits(variable.name, _of_axis(variable, words), COMMAND_BITS, length))
        if words or wires:
            return _bits(variable.name, {**_distinct(words), **wires}, 0, length)
        assert isinstance(variable.type, Integer)
        number = Signal(variable.name, 0, length, is_signed=variable.type.is_signed, choices=_choices(variable))
        return (self._measured(number, variable),)

    def _measured(self, signal: Signal, variable: Variable) -> Signal:
        """Return a signal with unit and limits, and with the name of its wire if it has one."""
        wire = next((of.settings for of in self.bindings if of.variable is variable and of.bit is None), None)
        if wire is not None:
            return replace(signal, name=wire.wire, scale=wire.scale, offset=wire.offset, unit=wire.unit)
        scale, unit = self._quantity(variable.index)
        low, high = (None if limit is None else limit * scale for limit in (variable.low, variable.high))
        return replace(signal, scale=scale, unit=unit, low=low, high=high)

    def _quantity(self, index: int) -> _Quantity:
        of_profile = of_first_axis(index)
        if of_profile in FIXED:
            return _Quantity(*FIXED[of_profile])
        axis = index - (of_profile or 0)
        if of_profile in POSITIONS and self._counts_increments(axis):
            return _Quantity(unit="inc")
        if of_profile in SPEEDS and self._counts_increments(axis):
            return _Quantity(unit="inc/s")
        return _Quantity()

    def _counts_increments(self, axis: int) -> bool:
        """Return whether a user unit is an increment: the feed is what the encoder counts, behind the gear."""
        numbers = [
            self.dictionary.number(axis + index, subindex) for index in (RESOLUTION, GEAR, FEED) for subindex in (1, 2)
        ]
        if not all(numbers):
            return False
        increments, revolutions, motor, shaft, feed, of_shaft = numbers
        return increments * motor * of_shaft == revolutions * shaft * feed

    def _wires_of_bits(self, variable: Variable) -> dict[int, str]:
        return {of.bit: of.settings.wire for of in self.bindings if of.variable is variable and of.bit is not None}


def error_names(dictionary: Dictionary | None) -> Mapping[int, str]:
    """Return the meaning of the error codes of a node."""
    return ERROR_NAMES_OF_DRIVES if dictionary is not None and is_drive(dictionary) else ERROR_NAMES


def _choices(variable: Variable) -> Mapping[int, str]:
    meaning = meaning_of(variable.index, variable.name)
    if meaning is mode_words:
        return MODES
    return ERROR_NAMES_OF_DRIVES if meaning is error_words else NO_CHOICES


def _bits(name: str, words: Mapping[int, str], first: int, end: int) -> Iterator[Signal]:
    """Yield bits with their names, and what is between them in one piece."""
    at = first
    for bit in sorted(bit for bit in words if first <= bit < end):
        if bit > at:
            yield _rest(name, at, bit)
        yield Signal(words[bit], bit, 1)
        at = bit + 1
    if at < end:
        yield _rest(name, at, end)


def _rest(name: str, first: int, end: int) -> Signal:
    return Signal(f"{name} {first}" if end == first + 1 else f"{name} {first} to {end - 1}", first, end - first)


def _distinct(words: Mapping[int, str]) -> dict[int, str]:
    """Return names of bits without those that say nothing of the bit, such as `reserved`."""
    return {bit: word for bit, word in words.items() if [*words.values()].count(word) == 1 and word != "reserved"}


def _of_axis(variable: Variable, words: Mapping[int, str]) -> dict[int, str]:
    """Return the names of the bits of a word with the axis, if the name of the object has it: `Axis 2 warning`."""
    axis = " ".join(WORD.sub(" ", variable.name).split())
    return {bit: f"{axis} {word}".lstrip() for bit, word in _distinct(words).items()}


STATES: Final = {bits: words for bits in range(1 << STATE_BITS) if (words := state_words(bits))}
"""The states by bits 0 to 6 of the status word."""
COMMAND_NAMES: Final = {bits: command_words(bits) for bits in range(1 << COMMAND_BITS)}
"""The commands by bits 0 to 3 of the control word, without a reset of a fault."""
