"""CiA 401: decides which changes of inputs are events that trigger TPDOs.

Source: CiA 401 version 3, objects 6005h to 6008h (digital) and 6421h to 6428h (analog).  Readings: limits and deltas
are in units of 6401h; a delta counts from the value of the last event; a change has to satisfy limits and deltas.
"""

from functools import partial

from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.canopen.variable import Variable

DIGITAL_INTERRUPT, MASK_ANY_CHANGE, MASK_RISING, MASK_FALLING = 0x6005, 0x6006, 0x6007, 0x6008
TRIGGER_SELECTION, ANALOG_INTERRUPT = 0x6421, 0x6423
UPPER_LIMIT, LOWER_LIMIT, DELTA, NEGATIVE_DELTA, POSITIVE_DELTA = 0x6424, 0x6425, 0x6426, 0x6427, 0x6428

ABOVE_UPPER, BELOW_LOWER, CHANGED, REDUCED, INCREASED = 0x01, 0x02, 0x04, 0x08, 0x10
"""Bits of the trigger selection, 6421h."""


class DigitalGate:
    """Decides whether a change of an input byte is an event (6005h to 6008h)."""

    def __init__(self, dictionary: Dictionary, variable: Variable) -> None:
        self._variable = variable
        self._number = partial(dictionary.number, subindex=variable.subindex)
        self._enable = partial(dictionary.number, DIGITAL_INTERRUPT, 0, 1)
        self._default = 0xFF if dictionary.get(MASK_ANY_CHANGE, variable.subindex) is None else 0
        self._now = self._changed = 0
        variable.watchers.append(self._on_change)
        variable.gate = self._is_event

    def reset(self) -> None:
        self._now = self._variable.number

    def _on_change(self) -> None:
        now = self._variable.number
        self._changed, self._now = now ^ self._now, now

    def _is_event(self) -> bool:
        wanted = self._number(MASK_ANY_CHANGE, default=self._default)
        wanted |= self._now & self._number(MASK_RISING, default=0)
        wanted |= ~self._now & self._number(MASK_FALLING, default=0)
        return bool(self._enable() and self._changed & wanted)


class AnalogGate:
    """Decides whether a change of an analog input is an event (6421h to 6428h)."""

    def __init__(self, dictionary: Dictionary, variable: Variable) -> None:
        self._variable = variable
        self._setting = partial(_setting, dictionary, subindex=variable.subindex)
        self._is_enabled = partial(_setting, dictionary, ANALOG_INTERRUPT, subindex=0, default=1)
        self._last = 0.0
        variable.gate = self._is_event

    def reset(self) -> None:
        self._last = _as_number(self._variable)

    def _is_event(self) -> bool:
        value = _as_number(self._variable)
        if not self._is_enabled() or not self._is_triggered(
            int(self._setting(TRIGGER_SELECTION, default=CHANGED)), value
        ):
            return False
        self._last = value
        return True

    def _is_triggered(self, selected: int, value: float) -> bool:
        setting, moved = self._setting, value - self._last
        limits = selected & (ABOVE_UPPER | BELOW_LOWER)
        deltas = selected & (CHANGED | REDUCED | INCREASED)
        is_beyond = (
            not limits
            or bool(limits & ABOVE_UPPER and value >= setting(UPPER_LIMIT, default=0))
            or bool(limits & BELOW_LOWER and value < setting(LOWER_LIMIT, default=0))
        )
        has_moved = (
            not deltas
            or bool(deltas & CHANGED and abs(moved) >= setting(DELTA, default=0))
            or bool(deltas & REDUCED and -moved >= setting(NEGATIVE_DELTA, default=0))
            or bool(deltas & INCREASED and moved >= setting(POSITIVE_DELTA, default=0))
        )
        return is_beyond and has_moved


def _setting(dictionary: Dictionary, index: int, *, subindex: int, default: float) -> float:
    variable = dictionary.get(index, subindex)
    return default if variable is None else _as_number(variable)


def _as_number(variable: Variable) -> float:
    value = variable.value
    return 0.0 if isinstance(value, str) else value
