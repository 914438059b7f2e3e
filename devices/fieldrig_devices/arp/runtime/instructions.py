"""The functions that compiled programs call: the card's instructions, with checks of their ranges.

Source: manual 5.6 to 5.12; digest chapter 5.  A value outside its range causes W03, and the instruction is not executed
(the manual only says that its effect is not guaranteed); TERM off the screen warns and shows the visible part.

Every name that generated code may use (`language.lower.NAMES`) is an attribute of `Instructions` with the same name.
"""

from collections.abc import Callable, Sequence
from typing import Any, Final

from fieldrig_devices.arp.fixed import SCALE, WRONG_PARAMETER, Arithmetic, whole
from fieldrig_devices.arp.language.instructions import CONSTANT, WRITABLE, Value, numbers
from fieldrig_devices.arp.language.lower import NAMES
from fieldrig_devices.arp.runtime.card import CamSwitch, Card, Shown
from fieldrig_devices.arp.runtime.events import BitEvent, Edge, Events, PositionEvent
from fieldrig_devices.arp.runtime.timers import Timers
from fieldrig_devices.arp.runtime.words import packed, unpacked

_PERCENT: Final = (0, 100_000)
_VOLT: Final = (-10_000, 10_000)
_SLOPE: Final = (10, 10_000)
_WAIT: Final = (1, 100_000)
_TIMER: Final = (10, 100_000)
_VARIABLES: Final = (1, 1_000)
_COUNTER_MAXIMUM, _COUNTER_MINIMUM = 5, 6  # axis parameters
_FREE_FLAG_WORDS: Final = 8  # words of flags in which the program may write every bit
_MODES: Final = ("", "E", "P")


class Instructions:
    def __init__(
        self, card: Card, timers: Timers, events: Events, texts: Sequence[str], start_wait: Callable[[int], None]
    ) -> None:
        """`start_wait` is called with the raw seconds of a WAIT whose value is within its range."""
        self._card, self._timers, self._events = card, timers, events
        self._texts, self._start_wait = texts, start_wait
        self.V, self.F, self.I, self.O = card.V, card.F, card.I, card.O
        self.terminals = numbers("O")
        arithmetic = Arithmetic(card.warn)
        self.saturated, self.divided_by_zero = arithmetic.saturated, arithmetic.divided_by_zero
        self.shifted_left, self.shifted_right = arithmetic.shifted_left, arithmetic.shifted_right
        self.root, self.integer = arithmetic.root, arithmetic.integer
        self.sine, self.cosine = arithmetic.sine, arithmetic.cosine
        self.position, self.set_position, self.speed = card.position, card.preset_position, card.speed
        self.latch_rising, self.latch_falling = card.latched_rising, card.latched_falling
        self.general, self.parameter = card.general_parameter, card.axis_parameter
        self.set_parameter = card.set_axis_parameter
        self.adc, self.home, self.stop, self.pst = card.read_analog, card.home, card.stop_axis, card.follow_table
        self.prc, self.cam_off = card.move_by, card.disarm_cam_switch
        self.term_clear = card.clear_screen
        self.tim, self.stim, self.on_off = timers.elapsed, timers.start, events.disarm

    def names(self) -> dict[str, Any]:
        """Names that generated code can use."""
        return {name: getattr(self, name) for name in NAMES}

    def _refused(self) -> None:
        self._card.warn(WRONG_PARAMETER)

    def _is_within(self, raw: int, span: tuple[int, int]) -> bool:
        """True if the value is within the span; W03 if not."""
        if span[0] <= raw <= span[1]:
            return True
        self._refused()
        return False

    def _is_one_of(self, number: int, known: frozenset[int]) -> bool:
        if number in known:
            return True
        self._refused()
        return False

    # ---- data

    def wrong_index(self) -> int:
        """Warn, and return the value of an element that does not exist; a write to it is dropped."""
        self._refused()
        return 0

    def set_flag(self, number: int, bit: int) -> None:
        """Write a flag with a computed number; a flag that only the system writes keeps its value."""
        if self._is_within(number, (1, 320)) and number in WRITABLE:
            self.F[number] = bit

    def flag_word(self, number: int) -> int:
        return packed(self.F[32 * number - 31 : 32 * number + 1])

    def set_flag_word(self, number: int, raw: int) -> None:
        first = 32 * number - 31
        if number <= _FREE_FLAG_WORDS:
            self.F[first : first + 32] = unpacked(raw)
            return
        for flag, bit in enumerate(unpacked(raw), first):
            if flag in WRITABLE:
                self.F[flag] = bit

    def output_word(self, number: int) -> int:
        return packed(self.O[100 * number + 1 : 100 * number + 33])

    def set_output_word(self, number: int, raw: int) -> None:
        self.O[100 * number + 1 : 100 * number + 33] = unpacked(raw)

    def input_word(self, number: int) -> int:
        return packed(self.I[100 * number + 1 : 100 * number + 33])

    def error(self) -> int:
        return self._card.last_error() * SCALE

    def warning(self) -> int:
        return self._card.last_warning() * SCALE

    # ---- time

    def wait(self, seconds: int) -> bool:
        """Start a wait.  Returns True if there is something to wait for."""
        if not self._is_within(seconds, _WAIT):
            return False
        self._start_wait(seconds)
        return True

    def stim_flag(self, number: int, seconds: int, flag: int) -> None:
        if self._is_within(seconds, _TIMER) and self._is_one_of(flag, WRITABLE):
            self._timers.start_with_flag(number, seconds, flag)

    # ---- analog outputs, axes

    def dac(self, channel: int, volt: int) -> None:
        if self._is_within(volt, _VOLT):
            self._card.write_analog(channel, volt, 0)

    def dac_slope(self, channel: int, volt: int, slope: int) -> None:
        if self._is_within(volt, _VOLT) and self._is_within(slope, _SLOPE):
            self._card.write_analog(channel, volt, slope)

    def vel(self, axis: int, percent: int) -> None:
        if self._is_within(percent, _PERCENT):
            self._card.limit_speed(axis, percent)

    def acc(self, axis: int, percent: int) -> None:
        if self._is_within(percent, _PERCENT):
            self._card.limit_acceleration(axis, percent)

    def dec(self, axis: int, percent: int) -> None:
        if self._is_within(percent, _PERCENT):
            self._card.limit_deceleration(axis, percent)

    def pac(self, axis: int, target: int) -> None:
        parameter = self._card.axis_parameter
        if self._is_within(target, (parameter(axis, _COUNTER_MINIMUM), parameter(axis, _COUNTER_MAXIMUM))):
            self._card.move_to(axis, target)

    def pvc(self, axis: int, percent: int) -> None:
        if self._is_within(percent, _PERCENT):
            self._card.move_at(axis, percent)

    def pid(self, cell: int, output: int, first: int) -> None:
        if self._is_within(first, (1, 1_000 - 24)):  # 25 variables
            self._card.regulate(cell, output, first)

    def cam(
        self, number: int, axis: int, set_at: int, reset_at: int, is_inverted: int, is_output: int, bit: int
    ) -> None:
        letter = "O" if is_output else "F"
        if self._is_one_of(bit, self.terminals if is_output else WRITABLE):
            self._card.arm_cam_switch(number, CamSwitch(axis, set_at, reset_at, bool(is_inverted), letter, bit))

    # ---- events

    def on_bit(self, number: int, routine: int, enable: int, edge: int, is_input: int, bit: int) -> None:
        known = self.terminals if is_input else numbers("F")
        if self._is_one_of(enable, numbers("F")) and self._is_one_of(bit, known):
            self._events.arm(number, BitEvent(routine, enable, Edge(edge), bool(is_input), bit))

    def on_position(self, number: int, routine: int, enable: int, axis: int, is_above: int, variable: int) -> None:
        if self._is_one_of(enable, numbers("F")) and self._is_within(variable, _VARIABLES):
            self._events.arm(number, PositionEvent(routine, enable, axis, bool(is_above), variable))

    # ---- terminal

    def msg(self, number: int, text: int) -> None:
        self._card.store_message(number, self._texts[text])

    def term_erase(self, line: int, column: int) -> None:
        if self._is_on_screen(line, column):
            self._card.erase_text(line, column)

    def term_show(self, line: int, column: int, height: int, message: int) -> None:
        self._show(line, column, height, message)

    def term_value(self, line: int, column: int, height: int, message: int, variable: int) -> None:
        self.term_edit(line, column, height, message, variable, 0)

    def term_edit(self, line: int, column: int, height: int, message: int, variable: int, mode: int) -> None:
        if self._is_within(variable, _VARIABLES):
            self._show(line, column, height, message, variable, _MODES[mode])

    def _show(
        self, line: int, column: int, height: int, message: int, variable: int | None = None, mode: str = ""
    ) -> None:
        if self._is_within(whole(message), CONSTANT[Value.MESSAGE]):
            self._is_on_screen(line, column)
            self._card.show_text(Shown(line, column, height, whole(message), variable, mode))

    def _is_on_screen(self, line: int, column: int) -> bool:
        return self._is_within(line, CONSTANT[Value.LINE]) and self._is_within(column, CONSTANT[Value.COLUMN])

    def print_message(self, message: int) -> None:
        self._print(message, None)

    def print_value(self, message: int, variable: int) -> None:
        if self._is_within(variable, _VARIABLES):
            self._print(message, variable)

    def _print(self, message: int, variable: int | None) -> None:
        if self._is_within(whole(message), CONSTANT[Value.PRINTED]):
            self._card.print_text(whole(message), variable)
