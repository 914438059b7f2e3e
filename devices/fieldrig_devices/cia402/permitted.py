"""The numbers that an object of an axis takes, where limits of the object do not say it all.

Source: CiA 402-2, tables of values of the objects.  A write by the network and a power-on value of a rig file are
judged alike.
"""

from collections.abc import Callable, Collection
from typing import Final, NamedTuple

from fieldrig_devices.canopen.abort import Abort, Code
from fieldrig_devices.cia402 import objects
from fieldrig_devices.cia402.axis_objects import Key
from fieldrig_devices.cia402.behaviour import Behaviour

NO_HOMING: Final = 0
"""Value of 6098h for no homing: the origin stays as it is, and there is nothing to search for."""
FROM_ACTUAL: Final = 2
RELATIVE_OPTION: Final = 0x0003
"""Bits 0 and 1 of 60F2h; bits 6 and 7 are the direction within the range, and the others are not supported."""
DIRECTION_OPTION: Final = 0x00C0
LINEAR, JERK_LIMITED = 0, 3
"""Values of 6086h; sin2 ramps (1) and jerk-free ramps (2) are not supported."""
ONE_JERK: Final = 1
"""Value of 60A3h: one jerk for all parts of a profile."""
PROBE_1, PROBE_2, HARDWARE_ZERO, SOFTWARE_ZERO = 1, 2, 5, 6
"""Sources in 60D0h."""
PROBE_SOURCE: Final = 0x0C
"""Bits of one half of 60B8h: the source of the probe."""
INPUT, ZERO, BY_OBJECT = 0x00, 0x04, 0x08
"""Sources in bits 2 and 3: the input of the probe, the encoder zero, or what 60D0h names."""


class Rule(NamedTuple):
    """The numbers of one object."""

    takes: Callable[[int], bool]
    wanted: str
    """The words for a message, such as `a mode of 6502h`."""

    def check(self, number: int) -> None:
        """Abort as for a write of this number."""
        if not self.takes(number):
            raise Abort(Code.INVALID_VALUE)


def homing_method(behaviour: Behaviour) -> Rule:
    """Return the rule of 6098h."""
    return _one_of(behaviour.homing_methods | ({NO_HOMING} if behaviour.accepts_no_homing else set()))


def start_rules(behaviour: Behaviour, modes: Collection[int]) -> dict[Key, Rule]:
    """Return the rules of the objects that may have a power-on value; 6060h is 0 as long as no mode is chosen."""
    return {
        (objects.MODE, 0): _one_of({0, *modes}),
        (objects.HOMING_METHOD, 0): homing_method(behaviour),
        (objects.POSITIONING_OPTION, 0): POSITIONING,
        (objects.PROBE_FUNCTION, 0): PROBE_FUNCTION,
        (objects.PROBE_SOURCE, 1): PROBE_SOURCES,
        (objects.PROBE_SOURCE, 2): PROBE_SOURCES,
        (objects.PROFILE_TYPE, 0): PROFILE_TYPES,
        (objects.JERK_USE, 0): JERK_USES,
    }


def _one_of(numbers: Collection[int]) -> Rule:
    known = frozenset(numbers)
    firsts = sorted(number for number in known if number - 1 not in known)
    lasts = sorted(number for number in known if number + 1 not in known)
    ranges = (str(first) if first == last else f"{first} to {last}" for first, last in zip(firsts, lasts, strict=True))
    return Rule(known.__contains__, f"one of {', '.join(ranges)}")


def _is_option(option: int) -> bool:
    return not option & ~(RELATIVE_OPTION | DIRECTION_OPTION) and option & RELATIVE_OPTION <= FROM_ACTUAL


def _is_function(word: int) -> bool:
    return all(half & PROBE_SOURCE in (INPUT, ZERO, BY_OBJECT) for half in (word & 0xFF, word >> 8))


POSITIONING: Final = Rule(_is_option, "bits 0 and 1 from 0 to 2, bits 6 and 7, and no others")
PROFILE_TYPES: Final = _one_of((LINEAR, JERK_LIMITED))
JERK_USES: Final = _one_of((ONE_JERK,))
PROBE_FUNCTION: Final = Rule(_is_function, "a source from 0 to 2 in bits 2 and 3, and in bits 10 and 11")
PROBE_SOURCES: Final = _one_of((PROBE_1, PROBE_2, HARDWARE_ZERO, SOFTWARE_ZERO))
