"""The kinds of objects and their parameters, as one table (sections 1.3 and 1.7 of the manual's digest).

Each line of a table gives a parameter: its name, what it holds, whether it must be there, and what a program may do
with it at run time (the manual's access levels: none NA, read RO, write WO, both RW).  `must` is required, `many` as
well and may appear again, `may` is optional; `one:x` requires a single parameter of the group x, `may:x` allows one.

What a parameter holds is one of: integer, number (not negative), signed, flagged words in parentheses such as
(YES NO), a reference to an object of one of the kinds in angles such as <NODE>, routine (NONE or a routine with its
arguments), file (the name of a cam profile), bit (a number from 0 to 7 behind BIT, or nothing for 0), any (a reference
to an object of any kind).
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

Access = Literal["NA", "RO", "WO", "RW"]


_ACCESS: Final[Mapping[str, Access]] = {"NA": "NA", "RO": "RO", "WO": "WO", "RW": "RW"}


@dataclass(frozen=True, slots=True)
class Rule:
    """A parameter of a kind of object."""

    name: str
    holds: tuple[str, ...]
    """The forms of its values, in their order."""
    need: str
    access: Access

    @property
    def words(self) -> tuple[str, ...]:
        """The symbolic values that it takes."""
        return tuple(word for part in self.holds if part[0] == "(" for word in part[1:-1].split("|"))

    @property
    def group(self) -> str:
        """The group of parameters that exclude each other, or nothing."""
        return self.need.partition(":")[2]


def rules(text: str) -> Mapping[str, Rule]:
    by_name: dict[str, Rule] = {}
    for line in filter(str.strip, text.splitlines()):
        name, *holds, need, access = line.split()
        by_name[name] = Rule(name, tuple(holds), need, _ACCESS[access])
    return by_name


_MULTIPLE = """
    NUMBER      integer         may:items  NA
    NODES_GROUP <NODES_GROUP>   may:items  NA
"""
_POSITION = """
    POSITION_PERIOD number        one:domain {0}
    POSITION_RANGE  signed signed one:domain NA
"""
_VALUE = """
    VALUE_PERIOD number         one:domain RW
    VALUE_RANGE  signed signed  one:domain {0}
"""
_CHANNEL = """
    NODE     <NODE>      must NA
    ADDRESS  integer     must NA
"""
_TIMEOUTS = """
    MASTER_READY_TIMEOUT         integer/(NONE) must RO
    MASTER_CONFIGURATION_TIMEOUT integer/(NONE) must RO
    MASTER_INACTIVITY_TIMEOUT    integer/(NONE) must RW
"""
_AT = "    RESERVED integer may NA\n    ADDRESS integer {0} must NA\n"
_LEVEL = "    ACTIVE   (HIGH|LOW)  must NA\n"
_SAMPLED = _LEVEL + "    PERIOD   integer     must NA\n    DEBOUNCE integer     must NA\n"

_TABLES: Final = {
    "NODES_GROUP": "    NUMBER integer must NA",
    "NODE": _MULTIPLE
    + """
    ADDRESS integer        must NA
    TYPE    (ST1|SMART_IO) must NA
    """,
    "AXIS": """
    NODE             <NODE>  must NA
    PULSES_PER_UNIT  signed  must NA
    TRAVEL_SPEED     number  must RW
    ACCELERATION     number  must RW
    DECELERATION     number  may  RW
    INITIAL_POSITION signed  must RW
    """
    + _POSITION.format("NA"),
    "BINARY_INPUT": _CHANNEL + _SAMPLED + "    ON (BINARY_INPUT) may NA",
    "DIGITAL_INPUT": _CHANNEL + _SAMPLED + "    BITS integer must NA\n    ON (DIGITAL_INPUT) may NA",
    "COUNTER_INPUT": _CHANNEL + _SAMPLED + "    ON (COUNTER_INPUT) may NA",
    "KEY_INPUT": _CHANNEL
    + """
    ACTIVE   (HIGH|LOW)                    must NA
    PERIOD   integer                       must NA
    DEBOUNCE integer                       may  NA
    MODE     (ON_OFF|TOGGLE|AUTOREPEAT)    must NA
    DELAY    integer                       may  NA
    REPEAT   integer                       may  NA
    ON       (KEY_INPUT|BINARY_INPUT)      may  NA
    """,
    "BINARY_OUTPUT": _CHANNEL + _LEVEL + "    ON (BINARY_OUTPUT) may NA",
    "DIGITAL_OUTPUT": _CHANNEL + _LEVEL + "    BITS integer must NA\n    ON (DIGITAL_OUTPUT) may NA",
    "ANALOG_OUTPUT": _CHANNEL + "    RANGE signed signed must NA\n    ON (ANALOG_OUTPUT) may NA",
    "LED_OUTPUT": _CHANNEL + "    ON (LED_OUTPUT) may NA",
    "D7SEG_OUTPUT": _CHANNEL + "    DIGITS integer must NA\n    FONT (HEXA) may NA\n    ON (D7SEG_OUTPUT) may NA",
    "PAM_ANALOG_OUTPUT": """
    UNITS_PER_VOLT signed  must NA
    OFFSET         signed  must NA
    ADDRESS        integer must NA
    """,
    "DC_MOTOR": """
    INC      <BINARY_OUTPUT>  must NA
    DEC      <BINARY_OUTPUT>  must NA
    ZERO     <BINARY_INPUT>   must NA
    ENCODER  <COUNTER_INPUT>  must NA
    TIMEOUT  integer          must NA
    BRAKING  integer          must NA
    """,
    "ENCODER": """
    NODE            <NODE>   must NA
    ADDRESS         integer  must RW
    PULSES_PER_UNIT signed   must RW
    """
    + _POSITION.format("RW"),
    "AXES_SET": "    OPTIMIZE (YES|NO) may NA\n    AXIS <AXIS> many NA",
    "SINK": "",
    "ZERO_POSITIONER": _MULTIPLE
    + """
    OBJECT          <AXIS>                   must       NA
    SENSOR          <BINARY_INPUT>           may        NA
    COARSE_SPEED    signed/(CURRENT)         may        RW
    COARSE_EDGE     (RISING|FALLING)         may        NA
    COARSE_MOVE     signed/(NONE)            may        RW
    FINE_SPEED      signed/(CURRENT)         may        RW
    FINE_EDGE       (RISING|FALLING)         may        NA
    FINE_MOVE       signed/(NONE)            may        RW
    RESOLVER_OFFSET signed                   may        RW
    """,
    "AMPLIFIER": """
    GAIN         signed          must RW
    OFFSET       signed          must RW
    GAIN_SLOPE   number/(MAX)    must RW
    OFFSET_SLOPE number/(MAX)    must RW
    """,
    "PROFILE": """
    FILE             file    must NA
    INPUT_AMPLITUDE  signed  must RW
    OUTPUT_AMPLITUDE signed  must RW
    INPUT_OFFSET     signed  must RW
    OUTPUT_OFFSET    signed  must RW
    """,
    "CAM": "    PROFILE <PROFILE> must WO" + _VALUE.format("NA"),
    "COMPARATOR": """
    REFERENCE              signed   one:mode RW
    THROUGH_ZERO_REFERENCE signed   one:mode RW
    ROUTINE                routine  may      WO
    REVERSE_ROUTINE        routine  may      WO
    """,
    "CONVERTER": """
    DESTINATION <AXIS|AXES_SET|SINK|PAM_ANALOG_OUTPUT> must NA
    MODE        (POSITION|SPEED|TORQUE|VALUE)          must NA
    """,
    "CORRECTOR": """
    CORRECTION_MODE      (IMMEDIATE|ON_REQUEST) must       NA
    CORRECTION_REFERENCE (INPUT|OUTPUT)         must       NA
    CORRECTION_SLOPE     number                 must       RW
    CORRECTION_LEVEL     number                 must       RW
    TRIGGER_MODE         (ONCE|REPETITIVE)      must       NA
    TRIGGER_INPUT        <BINARY_INPUT>         must       NA
    VALUE_PERIOD         number                 may:domain NA
    VALUE_RANGE          signed signed          may:domain NA
    DELAY_COMPENSATION   number                 must       RW
    """,
    "DERIVATOR": _VALUE.format("NA"),
    "DISTRIBUTOR": "    DIVISOR integer must NA\n    SHIFT integer must NA",
    "MULTI_COMPARATOR": """
    TIME_ORIGIN_SLOPE        (POSITIVE|NEGATIVE|ZERO_MAXIMUM|ZERO_MINIMUM) must WO
    TIME_ORIGIN_COMPARE_MODE (IMMEDIATE|NEXT_PERIOD)                       must WO
    TIME_ORIGIN_REFERENCE    signed                                        must RW
    TIME_ORIGIN_ROUTINE      routine                                       may  WO
    """
    + _VALUE.format("WO"),
    "TRACE": "    ROUTINE routine must WO",
    "PHASER": """
    PHASE         signed         must RW
    PHASE_SLOPE   number/(MAX)   must RW
    STANDBY_VALUE signed         must RW
    VALUE_PERIOD  number         must RW
    """,
    "PMP_GENERATOR": """
    FIRST_TRAVEL_SPEED number    must RW
    LAST_TRAVEL_SPEED  number    must RW
    ACCELERATION       number    must RW
    JERK               number    must RW
    INITIAL_POSITION   signed    must RW
    PERIOD             number    must RO
    ANTI_DELAY         (YES|NO)  may  NA
    """
    + _POSITION.format("RW"),
    "SAMPLER": """
    SOURCE <ENCODER|AXIS>       must NA
    MODE   (POSITION|SPEED)     must NA
    PERIOD number               must RO
    """,
    "TMP_GENERATOR": """
    TRAVEL_SPEED     number    must RW
    ACCELERATION     number    must RW
    DECELERATION     number    may  RW
    INITIAL_POSITION signed    must RW
    PERIOD           number    must RO
    ANTI_DELAY       (YES|NO)  may  NA
    """
    + _POSITION.format("RW"),
    "VME DUALPORT": "    DEFAULT_PERIOD integer must NA\n" + _TIMEOUTS,
    "DUAL_PORT": """
    START_ADDRESS  integer      must NA
    LENGTH         integer      must NA
    FIFO_IN_START  integer      must NA
    FIFO_IN_HEAD   integer      must NA
    FIFO_IN_TAIL   integer      must NA
    FIFO_OUT_START integer      must NA
    FIFO_OUT_HEAD  integer      must NA
    FIFO_OUT_TAIL  integer      must NA
    WATCH_DOG      integer      must NA
    PAM_READY      integer bit  must NA
    DUALPORT_READY integer bit  must NA
    HOST_READY     integer bit  must NA
    PERIOD         integer      must NA
    """
    + _TIMEOUTS,
    "RS422 PORT": "    PERIOD integer must NA\n" + _TIMEOUTS + "    PAM_WATCHDOG_MESSAGE_PERIOD integer must RW",
    **{
        f"{scope} {kind}": _MULTIPLE
        for scope in ("INTERNAL", "COMMON")
        for kind in ("FLAG_VAR", "WORD_VAR", "REAL_VAR")
    },
    **{
        f"{port} {direction} {kind}": _MULTIPLE + period
        for port, period in (("VME", "    PERIOD number may NA\n"), ("RS422", ""))
        for direction in ("INPUT", "OUTPUT")
        for kind in ("FLAG_VAR", "WORD_VAR", "LONG_VAR", "REAL_VAR")
    },
    **{
        f"{direction} {kind}": _MULTIPLE + _AT.format(bit)
        for direction in ("DUALPORT_IN", "DUALPORT_OUT")
        for kind, bit in (("FLAG_VAR", "bit"), ("WORD_VAR", ""))
    },
}
KINDS: Final[Mapping[str, Mapping[str, Rule]]] = {kind: rules(text) for kind, text in _TABLES.items()}
"""The parameters of each kind of declaration that is described by parameters."""

PORTS: Final[Mapping[str, str]] = {
    "VME DUALPORT": "DualPort",
    "DUAL_PORT": "DualPort",
    "RS422 PORT": "RS422Port",
}
"""The predeclared object that each kind of port is to a program (PAMS-083, PAMS-099)."""
PORT_PARAMETERS: Final[Mapping[str, Mapping[str, Rule]]] = {
    "DUALPORT": rules(_TIMEOUTS),
    "RS422PORT": {name: rule for name, rule in KINDS["RS422 PORT"].items() if rule.access != "NA"},
}
"""The parameters that a program reads and writes, as in DualPort:MASTER_INACTIVITY_TIMEOUT (PAMS-084)."""

SPECS: Final[Mapping[str, Mapping[str, Rule]]] = {
    "ACTIONS": rules(_MULTIPLE + "    CYCLES integer must NA"),
    "TASK": rules(
        _MULTIPLE
        + """
    DUPL                       integer may NA
    CYCLES                     integer may NA
    DEFAULT_SEQUENCE_WORKSPACE integer may NA
    """
    ),
    "SEQUENCE": rules("    WORKSPACE integer may NA"),
    "APPLICATION": rules("    BASIC_PAM_CYCLE integer must NA\n    DEFAULT_TASK_WORKSPACE integer may NA"),
}
"""The parameters in the SPECS of programs and in the header of the application."""

OLD_NAMES: Final[Mapping[tuple[str, str], str]] = {
    ("AXIS", "POSITION"): "INITIAL_POSITION",
    ("TMP_GENERATOR", "POSITION"): "INITIAL_POSITION",
    ("PMP_GENERATOR", "POSITION"): "INITIAL_POSITION",
    ("AXES_SET", "SHIFT"): "SUBSET",
    ("DC_MOTOR", "BREAKING"): "BRAKING",
    ("TASK", "PERIOD"): "CYCLES",
}
"""Names of earlier releases and of the listings, and what they are called in release 2.5 (PAML-015, PAML-302, E-09)."""

OUTPUT_BLOCKS: Final = frozenset({"CONVERTER"})
INPUT_BLOCKS: Final = frozenset({"SAMPLER", "TMP_GENERATOR", "PMP_GENERATOR"})
TRANSFORMERS: Final = frozenset(
    {"AMPLIFIER", "CAM", "COMPARATOR", "CORRECTOR", "DERIVATOR", "DISTRIBUTOR", "MULTI_COMPARATOR", "PHASER"}
)
"""The classes of pipe blocks (PAML-401)."""
