"""A dial string as its steps (ITU-T V.250, 6.3.1).

Digits go out by tones or pulses; `T` and `P` change between them.  `,` pauses, `W` waits for a dial tone, `@` for an
answer that is quiet, `!` opens the line for half a second.  Every other character is ignored, as the `-` in 06-22.
"""

from enum import Enum
from typing import Final, NamedTuple

from fieldrig.clock import MS
from fieldrig_bus.telephone.message import MOST_DIGITS


class Wait(Enum):
    PAUSE = ","
    TONE = "W"
    QUIET = "@"
    FLASH = "!"


class Digits(NamedTuple):
    digits: str
    is_pulse: bool


Step = Digits | Wait
TONE_DIGITS: Final = frozenset("0123456789ABCD*#")
PULSE_DIGITS: Final = frozenset("0123456789")
PULSE_NS: Final = 100 * MS
"""The duration of a pulse; 0 has ten."""
BETWEEN_NS: Final = 700 * MS
"""The pause after the pulses of a digit."""
_WAITS = {wait.value: wait for wait in Wait}


def steps_of(string: str, is_pulse: bool) -> list[Step]:
    """Return the steps of a dial string; `is_pulse` is how it begins."""
    steps: list[Step] = []
    for letter in string.upper():
        if letter in "TP":
            is_pulse = letter == "P"
        elif letter in _WAITS:
            steps.append(_WAITS[letter])
        elif letter in (PULSE_DIGITS if is_pulse else TONE_DIGITS):
            _add_digit(steps, letter, is_pulse)
    return steps


def _add_digit(steps: list[Step], digit: str, is_pulse: bool) -> None:
    last = steps[-1] if steps else None
    if isinstance(last, Digits) and last.is_pulse is is_pulse and len(last.digits) < MOST_DIGITS:
        steps[-1] = last._replace(digits=last.digits + digit)
    else:
        steps.append(Digits(digit, is_pulse))


def duration_ns(step: Digits, tone_ms: int) -> int:
    """Return the time that the digits take; a tone, and the pause after it, takes `tone_ms`."""
    if not step.is_pulse:
        return len(step.digits) * 2 * tone_ms * MS
    return sum((int(digit) or 10) * PULSE_NS + BETWEEN_NS for digit in step.digits)
