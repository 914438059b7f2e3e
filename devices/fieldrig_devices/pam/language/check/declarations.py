"""Declarations: which parameters must be there, and what they may hold (sections 1.3 and 1.7 of the digest)."""

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from fieldrig_devices.pam.language.check.expressions import indexed
from fieldrig_devices.pam.language.check.given import Given
from fieldrig_devices.pam.language.check.statements import check_routine_call
from fieldrig_devices.pam.language.check.symbols import (
    ITEMS_FROM,
    Context,
    Names,
    Symbol,
    listed,
    with_article,
)
from fieldrig_devices.pam.language.items import Application, Declaration, Parameter
from fieldrig_devices.pam.language.objects import KINDS, SPECS, Rule
from fieldrig_devices.pam.language.tree import Expression, Number, Place, Reference, RoutineCall, Word
from fieldrig_devices.smart_io.addresses import POSITIONS

LONGEST_NAME: Final = 11
"""Significant characters of the name of an application (PAML-011)."""
_COUNTS: Final = ("NUMBER", "CYCLES", "DUPL", "BASIC_PAM_CYCLE")
_SIGNED: Final = ("PULSES_PER_UNIT", "UNITS_PER_VOLT")
"""Parameters whose sign is a direction."""
LONGEST_FILE: Final = 8
"""Characters of the name of a cam file (manual line 4764)."""


def check_application(application: Application, names: Names) -> None:
    if len(application.name) > LONGEST_NAME:
        what = f"only {application.name[:LONGEST_NAME]} of {application.name} is shown"
        names.note(application.place, what, f"The name has {LONGEST_NAME} significant characters.")
    check_parameters("APPLICATION", SPECS["APPLICATION"], application.parameters, application.place, names)


def check_declaration(declaration: Declaration, names: Names) -> None:
    """Check an object and declare it."""
    kind = declaration.kind
    check_parameters(kind, KINDS[kind], declaration.parameters, declaration.place, names)
    values = {parameter.name: parameter for parameter in declaration.parameters}
    for rule in _RULES.get(kind, _VARIABLE if kind.endswith("_VAR") else ()):
        rule(declaration, values, names)
    names.declare(
        Symbol(
            declaration.name,
            kind.rpartition(" ")[2],
            declaration.place,
            _has_items(values, names),
            _has_one_item(values, names),
            declaration,
        )
    )
    for part in declaration.parts:
        check_declaration(part, names)


def _has_items(values: Mapping[str, Parameter], names: Names) -> bool:
    if "NUMBER" in values or ("NODES_GROUP" in values):
        return True
    for name in ITEMS_FROM:
        if name in values and isinstance(first := values[name].values[0], Reference):
            owner = names.symbols.get(first.name)
            return owner is not None and owner.is_multiple
    return False


def _has_one_item(values: Mapping[str, Parameter], names: Names) -> bool:
    number = _number(values, "NUMBER")
    if number is not None:
        return number == 1
    firsts = [values[name].values[0] for name in ("NODES_GROUP", *ITEMS_FROM) if name in values]
    owners = [names.symbols.get(owner.name) for owner in firsts if isinstance(owner, Reference)]
    return any(owner is not None and owner.has_one_item for owner in owners)


def check_parameters(
    kind: str, rules: Mapping[str, Rule], parameters: Sequence[Parameter], place: Place, names: Names
) -> None:
    """Report parameters that are missing, exclude each other or hold what they cannot."""
    present = {parameter.name for parameter in parameters}
    missing = [rule.name for rule in rules.values() if rule.need in ("must", "many") and rule.name not in present]
    if missing:
        names.wrong(place, f"{with_article(kind)} is not complete", ", ".join(f"{name} = ..." for name in missing))
    for group in dict.fromkeys(rule.group for rule in rules.values() if rule.group):
        members = [rule for rule in rules.values() if rule.group == group]
        given = [rule.name for rule in members if rule.name in present]
        expected = listed([rule.name for rule in members])
        if len(given) > 1:
            names.wrong(place, f"{with_article(kind)} has {' and '.join(given)}", f"{expected}, not both")
        elif not given and members[0].need.startswith("one"):
            names.wrong(place, f"{with_article(kind)} has none of {expected}", "one of them")
    for parameter in parameters:
        _check_values(kind, rules[parameter.name], parameter, names)
        if parameter.name == "AXIS" and len(parameter.values) == 2:
            _check_number(_SUBSET, "integer", parameter.values[1], names)


def _check_values(kind: str, rule: Rule, parameter: Parameter, names: Names) -> None:
    for value, holds in zip(parameter.values, rule.holds, strict=False):
        if isinstance(value, RoutineCall):
            check_routine_call(value, names, Context(where=f"the {kind}"), is_constant=True)
        elif holds[0] == "<":
            _check_object(kind, rule, holds, value, names)
        elif holds[0] == "(":
            if not isinstance(value, Word) or value.name not in rule.words:
                names.wrong(value.place, f"{rule.name} of {with_article(kind)} is wrong", listed(list(rule.words)))
        elif holds == "file":
            _check_file(value, names)
        else:
            _check_number(rule, holds.partition("/")[0], value, names)


def _check_object(kind: str, rule: Rule, holds: str, value: Expression, names: Names) -> None:
    kinds = holds[1:-1].split("|")
    expected = listed([with_article(name) for name in kinds])
    if not isinstance(value, Reference):
        names.wrong(value.place, f"{rule.name} of {with_article(kind)} is wrong", expected)
        return
    symbol = names.object(value)
    if symbol is None:
        return
    if symbol.kind not in kinds:
        names.wrong(value.place, f"{value.name} is {with_article(symbol.kind)}", expected)
    elif rule.need == "many":
        indexed(value, symbol, names, Context(), is_target=True)
    elif value.index is not None:
        names.wrong(value.place, f"{rule.name} has an index", value.name)


def _check_file(value: Expression, names: Names) -> None:
    if not isinstance(value, Reference) or value.index is not None or len(value.name) > LONGEST_FILE:
        names.wrong(value.place, "the name of the cam file is wrong", f"up to {LONGEST_FILE} letters and digits")


_SUBSET: Final = Rule("SUBSET", ("integer",), "may", "NA")


def _check_number(rule: Rule, holds: str, value: Expression | RoutineCall, names: Names) -> None:
    if isinstance(value, Word):
        return  # the parser takes only the words of the rule
    if not isinstance(value, Number):
        name = value.name if isinstance(value, Reference) else ""
        what = f"{rule.name} is {name}, which is not a number" if name else f"{rule.name} is not a number"
        names.wrong(value.place, what, "a number", names.likely(name, names.defined))
    elif holds in ("integer", "bit") and not isinstance(value.value, int):
        names.wrong(value.place, f"{rule.name} is {value.spelling}", "a whole number")
    elif value.value == 0 and rule.name in _COUNTS:
        names.wrong(value.place, f"{rule.name} is 0", "1 or more")
    elif holds in ("integer", "number", "bit") and value.value < 0:
        names.wrong(value.place, f"{rule.name} is {value.spelling}", "a number that is not negative")


# ---- what parameters of an object mean for each other

_Check = Callable[[Declaration, Mapping[str, Parameter], Names], None]


def _number(values: Mapping[str, Parameter], name: str) -> float | None:
    parameter = values.get(name)
    if parameter is None or not isinstance(parameter.values[0], Number):
        return None
    return parameter.values[0].value


def _positive(*parameters: str) -> _Check:
    """Report parameters that are zero."""

    def check(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
        for name in parameters:
            if _number(values, name) == 0 and name not in _COUNTS:  # a count of 0 has a message already
                expected = "a number that is not 0" if name in _SIGNED else "a number above 0"
                names.wrong(values[name].place, f"{name} is 0", expected)

    return check


def _range(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    for name in ("POSITION_RANGE", "VALUE_RANGE", "RANGE"):
        if name in values and len(values[name].values) == 2:
            low, high = values[name].values
            if isinstance(low, Number) and isinstance(high, Number) and low.value >= high.value:
                names.wrong(high.place, f"{name} ends at {high.spelling}", f"a number above {low.spelling}")


NODE_TYPES: Final = frozenset({"ST1", "SMART_IO"})


def _node_type(wanted: str) -> _Check:
    """Report an object on a node of the other type."""

    def check(declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
        node = values["NODE"].values[0] if "NODE" in values else None
        symbol = names.symbols.get(node.name) if isinstance(node, Reference) else None
        if symbol is None or symbol.declaration is None:
            return
        for parameter in symbol.declaration.parameters:
            kind = parameter.values[0] if parameter.name == "TYPE" else None
            if isinstance(kind, Word) and kind.name in NODE_TYPES - {wanted} and node is not None:
                what = f"{declaration.kind} {declaration.name} is on {symbol.name}, which is {with_article(kind.name)}"
                names.wrong(node.place, what, f"a node of TYPE {wanted}")

    return check


def _distribution(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    divisor, shift = _number(values, "DIVISOR"), _number(values, "SHIFT")
    if divisor is not None and shift is not None and shift >= max(divisor, 1):
        names.wrong(values["SHIFT"].place, f"SHIFT is {shift}", f"less than DIVISOR, which is {divisor}")


def _destination(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    """Report a mode that the destination of a converter does not have (PAML-481)."""
    if not {"DESTINATION", "MODE"} <= values.keys():
        return
    target, mode = values["DESTINATION"].values[0], values["MODE"].values[0]
    symbol = names.symbols.get(target.name) if isinstance(target, Reference) else None
    if symbol is None or not isinstance(mode, Word):
        return
    modes = _MODES.get(symbol.kind, ())
    if modes and mode.name not in modes:
        names.wrong(mode.place, f"{with_article(symbol.kind)} has no mode {mode.name}", listed(modes))


_MODES: Final[Mapping[str, Sequence[str]]] = {
    "AXES_SET": ("POSITION", "SPEED"),
    "AXIS": ("POSITION", "SPEED", "TORQUE"),
    "PAM_ANALOG_OUTPUT": ("VALUE",),
}


def _debounced_key(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    """Report a key on a binary input without DEBOUNCE, or a key of the keyboard with it (PAML-090, PAML-091)."""
    on = values["ON"].values[0] if "ON" in values else None
    is_binary = isinstance(on, Word) and on.name == "BINARY_INPUT"
    if is_binary and "DEBOUNCE" not in values:
        names.wrong(values["ON"].place, "a key on a binary input lacks DEBOUNCE", "DEBOUNCE = n")
    if not is_binary and "DEBOUNCE" in values:
        names.wrong(values["DEBOUNCE"].place, "a key of the keyboard has DEBOUNCE", "ON BINARY_INPUT, or no DEBOUNCE")


def _phases(declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    """Report phases of a zero positioner that are not complete (PAML-200)."""
    for phase in ("COARSE", "FINE"):
        given = [name for name in (f"{phase}_SPEED", f"{phase}_EDGE", f"{phase}_MOVE") if name in values]
        if 0 < len(given) < 3:
            expected = f"{phase}_SPEED, {phase}_EDGE and {phase}_MOVE, or none of them"
            names.wrong(values[given[0]].place, f"the phase {phase} is not complete", expected)
        if given and "SENSOR" not in values:
            names.wrong(declaration.place, f"the phase {phase} has no SENSOR", "SENSOR = a binary input")


def _motor(declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    """Report a motor whose parts are not on one SMART_IO (manual line 1950), or with one output for both ways."""
    motor = Given(declaration)
    parts = [_given(names, motor.text(name)) for name in ("INC", "DEC", "ZERO", "ENCODER")]
    nodes = {part.text("NODE") for part in parts if part is not None}
    types = {node.text("TYPE") for node in (_given(names, name) for name in nodes) if node is not None}
    if len(nodes) > 1 or "ST1" in types:
        what = f"the parts of {declaration.name} are on several nodes or an ST1"
        names.wrong(declaration.place, what, "one SMART_IO")
    if motor.text("INC") and motor.text("INC") == motor.text("DEC"):
        names.wrong(values["DEC"].place, f"INC and DEC are both {motor.text('INC')}", "two outputs")


def _given(names: Names, name: str) -> Given | None:
    symbol = names.symbols.get(name)
    return None if symbol is None or symbol.declaration is None else Given(symbol.declaration)


def _digits(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    digits = _number(values, "DIGITS")
    if digits is not None and digits != 1:
        names.wrong(values["DIGITS"].place, f"DIGITS is {digits}", "1, the display of a SMART_IO")


def _bits(_declaration: Declaration, values: Mapping[str, Parameter], names: Names) -> None:
    bits = _number(values, "BITS")
    if bits is not None and (bits == 0 or bits > POSITIONS):
        names.wrong(values["BITS"].place, f"BITS is {bits}", f"1 to {POSITIONS}, the channels of a module")


_VARIABLE: Final = (_positive("NUMBER", "PERIOD"),)
_RULES: Final[Mapping[str, Sequence[_Check]]] = {
    "NODES_GROUP": (_positive("NUMBER"),),
    "AXIS": (
        _node_type("ST1"),
        _positive("PULSES_PER_UNIT", "TRAVEL_SPEED", "ACCELERATION", "DECELERATION", "POSITION_PERIOD"),
        _range,
    ),
    "ENCODER": (_node_type("ST1"), _positive("PULSES_PER_UNIT", "POSITION_PERIOD"), _range),
    "DIGITAL_INPUT": (_node_type("SMART_IO"), _bits, _positive("PERIOD", "DEBOUNCE")),
    "DIGITAL_OUTPUT": (_node_type("SMART_IO"), _bits),
    "ANALOG_OUTPUT": (_node_type("SMART_IO"), _range),
    "LED_OUTPUT": (_node_type("SMART_IO"),),
    "D7SEG_OUTPUT": (_node_type("SMART_IO"), _digits),
    "PAM_ANALOG_OUTPUT": (_positive("UNITS_PER_VOLT"),),
    "DC_MOTOR": (_motor,),
    "KEY_INPUT": (_node_type("SMART_IO"), _debounced_key, _positive("PERIOD", "DEBOUNCE")),
    "BINARY_INPUT": (_positive("PERIOD", "DEBOUNCE"),),
    "COUNTER_INPUT": (_node_type("SMART_IO"), _positive("PERIOD", "DEBOUNCE")),
    "CAM": (_positive("VALUE_PERIOD"), _range),
    "CONVERTER": (_destination,),
    "CORRECTOR": (_positive("CORRECTION_SLOPE", "CORRECTION_LEVEL"), _range),
    "DERIVATOR": (_positive("VALUE_PERIOD"), _range),
    "DISTRIBUTOR": (_distribution,),
    "MULTI_COMPARATOR": (_positive("VALUE_PERIOD"), _range),
    "PHASER": (_positive("VALUE_PERIOD"),),
    "PMP_GENERATOR": (
        _positive("FIRST_TRAVEL_SPEED", "LAST_TRAVEL_SPEED", "ACCELERATION", "JERK", "PERIOD", "POSITION_PERIOD"),
        _range,
    ),
    "TMP_GENERATOR": (
        _positive("TRAVEL_SPEED", "ACCELERATION", "DECELERATION", "PERIOD", "POSITION_PERIOD"),
        _range,
    ),
    "SAMPLER": (_positive("PERIOD"),),
    "ZERO_POSITIONER": (_phases,),
}
