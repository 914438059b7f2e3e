"""The functions of each kind of object, and the functions of numbers (section 1.6 and chapter 6 of the digest).

A line of a table gives a function: its name, what it answers (`-` for an executive function) and its arguments.  An
argument is `number`, `integer`, `text`, an object in angles, or words in parentheses; `?` behind it makes it optional.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

Type = Literal["flag", "integer", "real", "text"]
"""The types of expressions: flags, integers of 32 bits with a sign, and reals of 64 bits (PAML-221 to PAML-223)."""


@dataclass(frozen=True, slots=True)
class Function:
    name: str
    answer: Type | None
    """None for an executive function."""
    arguments: tuple[str, ...] = ()

    @property
    def fewest(self) -> int:
        return sum(not argument.endswith("?") for argument in self.arguments)


def functions(text: str) -> Mapping[str, tuple[Function, ...]]:
    """Return the functions by their names; one name may have several forms."""
    by_name: dict[str, tuple[Function, ...]] = {}
    for line in filter(str.strip, text.splitlines()):
        name, answer, *arguments = line.split()
        form = Function(name, _ANSWERS[answer], tuple(arguments))
        by_name[name] = (*by_name.get(name, ()), form)
    return by_name


_ANSWERS: Final[Mapping[str, Type | None]] = {
    "-": None,
    "flag": "flag",
    "integer": "integer",
    "real": "real",
}
_MOVES = """
    absolute_move - number
    relative_move - number
    position      - number
    run           - number
"""
_ERROR = """
    error      flag
    error_code integer
    error_code flag integer
"""
_SWITCH = """
    set    -
    reset  -
    invert -
"""
_BLINK = "    blink -\n    no_blink -\n"
_READY = "    ready flag\n"
_VALUE = "    value real\n"
_AXIS = (
    _MOVES
    + _ERROR
    + _READY
    + """
    power_on      -
    power_off     -
    stop          -
    update_status -
    generator_position real
    pipe_motionless    flag
    position           real
    speed              real
    status             integer
    status             flag integer
"""
)
_GENERATOR = "    position real\n    speed real\n    acceleration real\n" + _READY

_TABLES: Final[Mapping[str, str]] = {
    "NODE": _ERROR,
    "AXIS": _AXIS,
    "AXES_SET": _AXIS,
    "KEY_INPUT": _SWITCH,
    "BINARY_OUTPUT": _SWITCH,
    "LED_OUTPUT": _SWITCH + _BLINK,
    "D7SEG_OUTPUT": _BLINK + "    display - text\n    display - number integer",
    "DC_MOTOR": _ERROR
    + _READY
    + """
    absolute_move         - number
    relative_move         - number
    position              - number
    run                   - (INC|DEC)
    stop                  -
    zero_position         - (INC|DEC) (HIGH|LOW)
    stroke_limits         - number number
    disable_stroke_limits -
    enable_stroke_limits  -
    position              integer
    """,
    "ENCODER": _READY + _VALUE + "    position - number\n    position real\n    speed real",
    "ZERO_POSITIONER": _READY + "    start -\n    stop -",
    "FLAG_VAR": _SWITCH,
    "AMPLIFIER": _READY + _VALUE,
    "CAM": _READY + _VALUE,
    "COMPARATOR": _READY + _VALUE,
    "CONVERTER": _READY
    + """
    disactivate       -
    deactivate        -
    connect           - <AXIS>
    connect_all       -
    disconnect        - <AXIS>
    disconnect_all    -
    change_ratio      - <AXIS> number
    change_all_ratios - number
    """,
    "CORRECTOR": _READY
    + _VALUE
    + """
    trigger          - number
    trigger_off      -
    start_correction - number?
    triggered        flag
    latched_value    real
    latched_d_value  real
    latched_dd_value real
    correction       real
    """,
    "DERIVATOR": _READY + _VALUE,
    "DISTRIBUTOR": _VALUE,
    "MULTI_COMPARATOR": _VALUE + "    learn -\n    execute -\n    execute flag",
    "TRACE": """
    install_reference - (POSITIVE|NEGATIVE|ZERO_MAXIMUM|ZERO_MINIMUM) (IMMEDIATE|NEXT_PERIOD) number number
    """,
    "PHASER": _READY + _VALUE + "    start -\n    stop -",
    "PMP_GENERATOR": _GENERATOR
    + """
    position      - number
    absolute_move - number number?
    relative_move - number number?
    run           - number
    """,
    "SAMPLER": _VALUE,
    "TMP_GENERATOR": _GENERATOR + _MOVES,
    "DUALPORT": _ERROR,
    "RS422PORT": _ERROR,
    "PAMDISPLAY": "".join(
        f"    {kind} - integer text number?\n" for kind in ("message", "warning", "end_warning", "error", "end_error")
    ),
}
_ALL: Final = {kind: functions(text) for kind, text in _TABLES.items()}


def _chosen(is_inquiry: bool) -> Mapping[str, Mapping[str, tuple[Function, ...]]]:
    def of(table: Mapping[str, tuple[Function, ...]]) -> Mapping[str, tuple[Function, ...]]:
        kept = {name: tuple(form for form in forms if bool(form.answer) is is_inquiry) for name, forms in table.items()}
        return {name: forms for name, forms in kept.items() if forms}

    return {kind: of(table) for kind, table in _ALL.items()}


EXECUTIVE: Final = _chosen(is_inquiry=False)
"""The functions that an object carries out, as in AXI_Belt <- stop."""
INQUIRIES: Final = _chosen(is_inquiry=True)
"""The questions that an object answers, as in AXI_Belt ? ready."""

EXECUTIVE_NAMES: Final = frozenset(name for table in EXECUTIVE.values() for name in table)
INQUIRY_NAMES: Final = frozenset(name for table in INQUIRIES.values() for name in table)

REPLACED: Final[Mapping[str, str]] = {
    "travel_speed": "TRAVEL_SPEED",
    "acceleration": "ACCELERATION",
    "deceleration": "DECELERATION",
    "reference": "REFERENCE",
    "through_zero_reference": "THROUGH_ZERO_REFERENCE",
    "delay_compensation": "DELAY_COMPENSATION",
}
"""Functions of earlier releases, and the parameter that is written in their place (PAML-015)."""

_MATHEMATICS = "abs ceil floor exp ln log10 sqrt cos sin tan acos asin atan cosh sinh tanh"
MATHEMATICS: Final = frozenset(_MATHEMATICS.split())
"""The functions of numbers, written as inquiries: x ? sqrt.  All but abs answer a real."""

VALUES: Final[Mapping[str, Type]] = {
    "BINARY_INPUT": "flag",
    "KEY_INPUT": "flag",
    "BINARY_OUTPUT": "flag",
    "LED_OUTPUT": "flag",
    "BOOLEAN": "flag",
    "FLAG_VAR": "flag",
    "DIGITAL_INPUT": "integer",
    "COUNTER_INPUT": "integer",
    "DIGITAL_OUTPUT": "integer",
    "ANALOG_OUTPUT": "integer",
    "PAM_ANALOG_OUTPUT": "integer",
    "WORD_VAR": "integer",
    "LONG_VAR": "integer",
    "REAL_VAR": "real",
    "ENCODER": "real",
    "PAMDISPLAY": "real",
}
"""The types of the objects whose names alone are values in an expression."""

_WRITABLE = (
    "BINARY_OUTPUT DIGITAL_OUTPUT ANALOG_OUTPUT LED_OUTPUT PAM_ANALOG_OUTPUT "
    "FLAG_VAR WORD_VAR LONG_VAR REAL_VAR PAMDISPLAY"
)
WRITABLE: Final = frozenset(_WRITABLE.split())
"""The kinds of objects that `name <- expression` sets."""
