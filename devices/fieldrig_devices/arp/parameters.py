"""The card's parameters: general ones, @Par[1] to @Par[16], and those of each axis, @ParX[1] to @ParX[25].

Source: manual 3.1 and 3.2; digest chapter 6, whose defaults are ours, since the manual prints only one (kind of axis).
Values are raw integers (value x 1000).  Each parameter has a copy in flash, which only the service port changes, and a
copy in RAM, which is in effect.  RAM is loaded from flash at every start and reset, and the program changes it.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from fieldrig_devices.arp.fixed import LIMIT, SCALE

GENERAL: Final = 0
"""Group of the general parameters; groups 1 and 2 are the axes'."""


class Par(IntEnum):
    """Numbers of the general parameters."""

    CONTROL_PERIOD_MS = 1
    LOAD_CELL_1_RANGE = 2
    LOAD_CELL_2_RANGE = 3
    LOAD_CELL_FILTER_HZ = 4
    CAN_NODE_ID = 5
    CAN_KBAUD = 6
    TERMINAL_NODE_ID = 8
    DIAGNOSTIC_1_SOURCE = 10
    DIAGNOSTIC_1_GAIN = 11
    DIAGNOSTIC_1_OFFSET = 12
    DIAGNOSTIC_2_SOURCE = 13
    DIAGNOSTIC_2_GAIN = 14
    DIAGNOSTIC_2_OFFSET = 15
    SCHEDULER_PERIOD_MS = 16


class ParX(IntEnum):
    """Numbers of the parameters of an axis; positions are in user units."""

    COUNTS_PER_UNIT = 1
    COUNTS_PER_TURN = 2
    SIGNS = 3
    KIND = 4
    COUNTER_MAXIMUM = 5
    COUNTER_MINIMUM = 6
    SPEED = 7
    ACCELERATION = 8
    FEED_FORWARD = 10
    KP = 11
    KI = 12
    KD = 13
    TRACKING_ERROR = 14
    ARRIVAL_DWELL_S = 15
    ARRIVAL_WINDOW = 16
    SLAVE_OFFSET = 19
    SLAVE_OFFSET_STEP = 20
    MASTER_GEAR = 21
    MASTER_OFFSET = 22
    MASTER_OFFSET_STEP = 23
    MASTER_SPEED = 24
    ENTRY_PERCENT = 25


class Kind(IntEnum):
    """Kind of an axis, @ParX[4]."""

    ENCODER = 0
    SIMULATED = 1
    CONTROLLED = 2
    PID = 3


@dataclass(frozen=True, slots=True)
class Parameter:
    """Range and default of a parameter; all values are raw."""

    name: str
    unit: str
    low: int
    high: int
    default: int
    only: tuple[int, ...] = ()
    """Permitted values, if not every value from low to high is."""

    def takes(self, raw: int) -> bool:
        return raw in self.only if self.only else self.low <= raw <= self.high

    @property
    def is_whole(self) -> bool:
        """True if the parameter is a number without decimals."""
        return self.unit in ("ms", "Hz", "kbaud", "code", "count")


def _code(name: str, default: int, *only: int, unit: str = "code") -> Parameter:
    allowed = tuple(SCALE * value for value in only)
    return Parameter(name, unit, min(allowed), max(allowed), SCALE * default, allowed)


def _whole(name: str, unit: str, low: int, high: int, default: int) -> Parameter:
    return _code(name, default, *range(low, high + 1), unit=unit)


def _real(name: str, unit: str, low: int, high: int, default: int) -> Parameter:
    return Parameter(name, unit, low, high, default)


_RESERVED: Final = Parameter("reserved", "", -LIMIT, LIMIT, 0)
_SOURCES: Final = (*range(10), *range(11, 20))  # sources of a diagnostic output; digest I-05
_LOAD_CELL: Final = (0, 1, 2)

GENERAL_PARAMETERS: Final[Mapping[int, Parameter]] = {
    1: _whole("sampling period of the control loop", "ms", 1, 10, 2),
    2: _code("range of load cell 1", 0, *_LOAD_CELL),
    3: _code("range of load cell 2", 0, *_LOAD_CELL),
    4: _code("filter of the load cells", 100, 50, 100, 250, 500, 1000, unit="Hz"),
    5: _whole("CAN node-ID of the card", "code", 1, 127, 10),
    6: _code("CAN bit rate", 500, 125, 250, 500, 1000, unit="kbaud"),
    7: _RESERVED,
    8: _whole("CAN node-ID of the terminal", "code", 1, 127, 20),
    9: _RESERVED,
    10: _code("source of diagnostic output 1", 0, *_SOURCES),
    11: _real("gain of diagnostic output 1", "", -LIMIT, LIMIT, SCALE),
    12: _real("offset of diagnostic output 1", "V", -LIMIT, LIMIT, 0),
    13: _code("source of diagnostic output 2", 0, *_SOURCES),
    14: _real("gain of diagnostic output 2", "", -LIMIT, LIMIT, SCALE),
    15: _real("offset of diagnostic output 2", "V", -LIMIT, LIMIT, 0),
    16: _whole("period of the scheduler", "ms", 10, 100, 20),
}
AXIS_PARAMETERS: Final[Mapping[int, Parameter]] = {
    1: _real("encoder counts per unit", "count/unit", 1, LIMIT, SCALE),
    2: Parameter("encoder counts per turn", "count", SCALE, 100_000 * SCALE, 4_000 * SCALE),
    3: _whole("signs of encoder and output", "code", 0, 3, 0),
    4: _whole("kind of axis", "code", 0, 3, 0),
    5: _real("maximum of the position counter", "unit", -LIMIT, LIMIT, LIMIT),
    6: _real("minimum of the position counter", "unit", -LIMIT, LIMIT, -LIMIT),
    7: _real("maximum speed", "unit/s", 1, LIMIT, 10_000 * SCALE),
    8: _real("maximum acceleration", "unit/s2", 1, LIMIT, 100_000 * SCALE),
    9: _RESERVED,
    10: _real("feed-forward gain", "", 0, LIMIT, 0),
    11: _real("KP", "", 0, LIMIT, SCALE),
    12: _real("KI", "", 0, LIMIT, 0),
    13: _real("KD", "", 0, LIMIT, 0),
    14: _real("maximum tracking error", "unit", 0, LIMIT, 1_000 * SCALE),
    15: _real("time in the arrival window", "s", 0, 60_000, 50),
    16: _real("arrival window", "unit", 0, LIMIT, SCALE),
    17: _RESERVED,
    18: _RESERVED,
    19: _real("offset of the slave's reference", "unit", -LIMIT, LIMIT, 0),
    20: _real("step of the slave's offset in a sampling period", "unit", 0, LIMIT, 0),
    21: _real("gear of the master's reading", "", -10_000, 10_000, SCALE),
    22: _real("offset of the master's reading", "unit", -LIMIT, LIMIT, 0),
    23: _real("step of the master's offset in a sampling period", "unit", 0, LIMIT, 0),
    24: _real("maximum master speed", "unit/s", 1, LIMIT, 5_000 * SCALE),
    25: _real("speed of entry into the cam", "%", 1, 100_000, 10_000),
}
PARAMETERS: Final = (GENERAL_PARAMETERS, AXIS_PARAMETERS, AXIS_PARAMETERS)
"""Tables of the parameters, by group."""


def defaults(group: int) -> list[int]:
    """Default values of one group, raw; element 0 is not used."""
    table = PARAMETERS[group]
    return [0, *(table[number].default for number in sorted(table))]


ParameterValues = Mapping[tuple[int, int], int]
"""Raw values by group and number."""


class Parameters:
    """Copies of the parameters in flash and in RAM, by group and number."""

    def __init__(self) -> None:
        self.flash = [defaults(group) for group in range(len(PARAMETERS))]
        self.ram = [list(table) for table in self.flash]
        self.version = 0
        """Number of changes to `ram`, for users that cache what they derive from it."""

    def load(self) -> None:
        """Load RAM from flash, as a start and a reset do."""
        for ram, flash in zip(self.ram, self.flash, strict=True):
            ram[:] = flash
        self.version += 1

    def set_ram(self, group: int, number: int, raw: int) -> bool:
        """Write the copy in RAM.  False, without a change, if the value is out of range."""
        if not self.takes(group, number, raw):
            return False
        self.ram[group][number] = raw
        self.version += 1
        return True

    @staticmethod
    def takes(group: int, number: int, raw: int) -> bool:
        parameter = PARAMETERS[group].get(number)
        return parameter is not None and parameter.takes(raw)
