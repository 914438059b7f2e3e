"""Calls of standard functions: their arguments in order, the overload that their types mean, and operators as calls."""

import re
from collections.abc import Collection, Sequence
from itertools import pairwise
from typing import Final, TypeGuard

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    constants,
    enable,
    enum_texts,
    registers,
    special,
)
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.literal_only import DIVISIONS, are_whole, is_real
from fieldrig_devices.iec.check.project import start_of
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.check.untyped import Untyped, integer
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import conversions, fixed, intrinsics, templates
from fieldrig_devices.iec.library.arguments import plain
from fieldrig_devices.iec.library.timed import TIMED
from fieldrig_devices.iec.program import (
    COMPARISONS,
    CallFunction,
    Constant,
    Expression,
    Kept,
    Load,
    Operator,
    Result,
    Swapped,
    Target,
)
from fieldrig_devices.iec.types import ArrayType, EnumType, StringType, StructType, Type


def call(checker: Checker, name: str, node: tree.Call, wanted: Type | None) -> Expression | None:
    parts = enable.split(checker, node, None)
    given = _in_order(checker.context, name, parts[0]) if parts is not None else None
    if given is None or parts is None:
        return None
    around = None if name in DIVISIONS and is_real(wanted) and are_whole(given) else wanted
    values = [_value(checker, argument, wanted_inside(name, around, n)) for n, argument in enumerate(given)]
    if any(value is None and argument is not None for value, argument in zip(values, given, strict=True)):
        return None
    whole = _with_defaults(checker.context, name, values, node)
    nodes = [argument or node for argument in given]
    call = of_values(checker, name, whole, node, wanted, nodes) if whole is not None else None
    return enable.result(checker, call, parts[1], wanted, node) if call is not None else None


def _value(checker: Checker, argument: tree.Expression | None, wanted: Type | None) -> Expression | None:
    if argument is None:
        return None
    return checker.expression(argument, wanted)


def wanted_inside(name: str, wanted: Type | None, position: int = 0) -> Type | None:
    """Return the type that the surroundings of an argument have: REAL in REAL_TO_INT(EXPT(a, b)), INT in LEFT(s, 3)."""
    pair = conversions.pair(name)
    if pair is not None:
        return pair[0]
    known = fixed.FIXED.get(name)
    return known.parameters[position] if known is not None and position < len(known.parameters) else wanted


_SELECTORS: Final = {"G": Constant(False, Elementary.BOOL), "K": integer(0), "N": integer(0)}
"""The arguments that have other types than the values of a function, at their start values."""


def _with_defaults(
    context: Context, name: str, values: Sequence[Expression | None], node: tree.Call
) -> list[Expression] | None:
    """Fill in the start values of the arguments that a formal call leaves out; they have the type of the others."""
    names = intrinsics.formal_names(name, len(values))
    pairs = list(zip(names, values, strict=False))
    kinds = [value.type for formal, value in pairs if value is not None and formal not in _SELECTORS]
    made: list[Expression] = []
    for position, value in enumerate(values):
        if value is not None:
            made.append(value)
            continue
        known = fixed.FIXED.get(name)
        kind = known.parameters[position] if known is not None else kinds[0] if kinds else Elementary.INT
        start = start_of(kind)
        if start is None:
            context.say(node, f"the argument {names[position]} is missing in the call of {name}", ", ".join(names))
            return None
        made.append(_SELECTORS.get(names[position]) or Constant(start, kind))
    return made


def _note_number(context: Context, values: Sequence[Expression], at: tree.Node) -> None:
    """Note a constant number of MUX for which there is no input."""
    number = constants.folded(values[0])
    last = len(values) - 2
    if last > 0 and isinstance(number, Constant) and isinstance(number.value, int) and not 0 <= number.value <= last:
        what = f"MUX has no input with the number {number.value}, so it selects the last one"
        context.note(at, what, f"The first input has the number 0, and the last one {last}.")


def _number_of(context: Context, name: str, node: tree.Call) -> int:
    """Return how many arguments a call means, with those that a formal call of edition 3 leaves out."""
    count = len(node.arguments)
    is_formal = count > 0 and all(argument.name for argument in node.arguments)
    if not is_formal or not context.project.dialect.allows_missing_inputs:
        return count
    numbers = [int(argument.name[2:]) for argument in node.arguments if re.fullmatch(r"(?i)IN\d{1,3}", argument.name)]
    return max(count, intrinsics.fewest(name), *(number + 2 * (name == "MUX") for number in numbers), 1)


def _in_order(context: Context, name: str, node: tree.Call) -> list[tree.Expression | None] | None:
    """The arguments by position; named ones are put in order, with None for those that the call leaves out."""
    names = intrinsics.formal_names(name, _number_of(context, name, node))
    positions = {formal: number for number, formal in enumerate(names)}
    given: dict[str, tree.Expression] = {}
    for position, argument in enumerate(node.arguments):
        if argument.value is None or argument.is_output:
            context.say(argument, f"{name} has no outputs", "arguments without =>")
            return None
        formal = _as_in_standard(argument.name.upper(), positions) or (
            names[position] if position < len(names) else str(position)
        )
        if (argument.name and formal not in positions) or formal in given:
            context.say(argument, f"{name} has no free argument {argument.name}", ", ".join(names))
            return None
        given[formal] = argument.value
    if len(names) > len(node.arguments) and _number_of(context, name, node) > len(node.arguments):
        return [given.get(formal) for formal in names]
    return [given[formal] for formal in sorted(given, key=lambda formal: positions.get(formal, 99))]


_OF_CODESYS: Final = {"IN": ("STR",), "IN1": ("STR1",), "IN2": ("STR2",), "L": ("LEN", "SIZE"), "P": ("POS",)}
"""The names of CoDeSys by those of the standard, where functions for strings have others."""


def _as_in_standard(name: str, names: Collection[str]) -> str:
    """Return the name of an argument in `names`; the standard has IN1 where CoDeSys has STR1, and L for LEN."""
    others = (f"IN{name.removeprefix('STR')}",) if name.startswith("STR") else _OF_CODESYS.get(name, ())
    return name if name in names else next((other for other in others if other in names), name)


def of_values(
    checker: Checker,
    name: str,
    values: Sequence[Expression],
    at: tree.Node,
    wanted: Type | None = None,
    nodes: Sequence[tree.Node] = (),
) -> Expression | None:
    """Call a standard function with checked arguments; `nodes` are their trees, for messages."""
    operator = intrinsics.OPERATORS.get(name)
    if operator is not None:
        return _operator_call(checker, name, operator, values, at)
    named = enum_texts.call(checker.context, name, values, at)
    if named is not None:
        return named
    if name in TIMED:
        return _timed(checker, name, values, at, nodes)
    if name == "MUX" and values:
        _note_number(checker.context, values, nodes[0] if nodes else at)
    if name in ("SEL", "MUX") and values and isinstance(values[-1].type, StructType | ArrayType):
        return _selected(checker, name, values, at)
    if name in intrinsics.BYTE_ORDERS and len(values) == 1 and isinstance(values[0].type, StructType | ArrayType):
        return _in_byte_order(checker, name, values[0], at)
    if name in templates.SHIFTS:
        values = [*values[:1], *map(_steps, values[1:])]
    name, values = registers.conversion(name, values)
    values, power = registers.powers(checker.context, values, wanted) if name == "EXPT" else (values, None)
    is_of_standard = name in fixed.ON_TEXTS and not checker.context.mixes_integers
    if is_of_standard:
        values = [_position(checker, value, at) for value in values]
    kinds = [value.argument if type(value) is Untyped else value.type for value in values]
    dialect = checker.context.project.dialect
    durations = dialect.durations
    if name == "TRUNC" and dialect.truncates_to_32_bits and not _is_integer(wanted):
        wanted = Elementary.DINT
    overload = intrinsics.find(conversions.of_dialect(name, durations), kinds, wanted)
    if isinstance(overload, str):
        for time in durations.values():
            overload = overload.replace(time.name, str(time))
        head, _, rest = overload.partition(": expected ")
        expected, _, got = rest.rpartition(", got ")
        checker.context.say(at, f"{head} with {got}" if got else overload, expected)
        return None
    if not checker.context.mixes_integers:
        overload = intrinsics.transferring(overload)
    if dialect.writes_todays_texts:
        overload = intrinsics.of_today(overload)
    if dialect.rounds_halves_away:
        overload = intrinsics.rounding_away(overload)
    places = nodes or [at] * len(values)
    converted = [
        checker.convert(value, kind, node)
        for value, kind, node in zip(values, overload.parameters, places, strict=True)
    ]
    known = [
        constants.folded(_cut(value, kind))
        for value, kind in zip(converted, overload.parameters, strict=True)
        if value is not None
    ]
    if len(known) < len(converted):
        return None
    made = constants.intrinsic(overload, known)
    whole = (
        _whole(checker, name, values, overload.parameters, at, nodes) if name in registers.OF_THEIR_ARGUMENTS else None
    )
    if whole is not None:
        return constants.narrowed(whole, made.type)
    if power is not None:
        return constants.converted(made, power)
    if isinstance(made.type, EnumType) and "TO_" in name:
        return constants.converted(made, made.type.base)  # a number, though a value of an enumeration is one already
    if isinstance(made.type, Elementary) and made.type in durations:
        return constants.converted(made, durations[made.type])
    is_length = is_of_standard and made.type is Elementary.INT
    return constants.converted(made, wanted) if is_length and wanted is not None and is_number(wanted) else made


def _timed(
    checker: Checker, name: str, values: Sequence[Expression], at: tree.Node, nodes: Sequence[tree.Node]
) -> Expression | None:
    """Call a function such as ADD_TOD_TIME, an operator whose operands have these types."""
    operator, *kinds = TIMED[name]
    if len(values) != len(kinds):
        checker.context.say(at, f"{name} with {len(values)} arguments", "two arguments")
        return None
    made = [
        checker.convert(value, _of_dialect(checker.context, kind), node) if kind is not None else value
        for value, kind, node in zip(values, kinds, nodes or [at] * len(values), strict=True)
    ]
    left, right = made
    return checker.operate(operator, left, right, at) if left is not None and right is not None else None


def _of_dialect(context: Context, kind: Elementary) -> Elementary:
    return context.project.dialect.durations.get(kind, kind)


def _selected(checker: Checker, name: str, values: Sequence[Expression], at: tree.Node) -> Expression | None:
    """Return what SEL or MUX of structures or arrays selects: the variable with the address that is selected."""
    kind, addresses = values[-1].type, list[Expression]()
    for value in values[1:]:
        if value.type != kind or not isinstance(value, Load):
            checker.context.say(at, f"{name} with {a(value.type)} beside {a(kind)}", "variables of the same type")
            return None
        address = special.address_of(checker, value.place, at)
        if address is None:
            return None
        addresses.append(address)
    selection = of_values(checker, name, [values[0], *addresses], at)
    return Load(Target(selection, kind)) if selection is not None else None


def _in_byte_order(checker: Checker, name: str, value: Expression, at: tree.Node) -> Expression | None:
    """Return a structure or an array with each of its values in the byte order of the function (table 38)."""
    context = checker.context
    if not isinstance(value, Load | CallFunction) or not intrinsics.has_byte_order(value.type):
        expected = "one of numbers, bit strings, durations, dates with time and STRINGs"
        context.say(at, f"{name} with {a(value.type)}", expected)
        return None
    if context.source is None:
        context.say(at, f"{name} where no statement is", "assign its result in a statement")
        return None
    place = value.place if isinstance(value, Load) else Result(value)
    in_order = value if "LITTLE" in name else Load(Swapped(place))
    return Load(Kept(in_order, context.hidden("order", value.type)))


def _whole(
    checker: Checker,
    name: str,
    values: Sequence[Expression],
    parameters: Sequence[Type],
    at: tree.Node,
    nodes: Sequence[tree.Node],
) -> Expression | None:
    """Return the function of arguments that arithmetic has made larger than their type; None if none is."""
    whole = registers.whole_arguments(checker.context, name, values, parameters)
    made = of_values(checker, name, whole, at, parameters[-1], nodes) if whole is not None else None
    return made if made is not None and made.type in constants.REGISTER.values() else None


def _steps(value: Expression) -> Expression:
    """Return the number of bits of a shift, which is any integer, as a DWORD."""
    is_integer = isinstance(value.type, Elementary) and value.type.is_integer
    return constants.converted(value, Elementary.DWORD) if is_integer and type(value) is not Untyped else value


def is_number(kind: Type) -> TypeGuard[Elementary]:
    """True for the ANY_INT of the standard."""
    return isinstance(kind, Elementary) and kind.family in (Family.SIGNED, Family.UNSIGNED)


def _is_integer(wanted: Type | None) -> bool:
    """True for an integer, a bit string, or an enumeration or a subrange of them."""
    kind = plain(wanted) if wanted is not None else None
    return isinstance(kind, Elementary) and kind.is_integer


def _position(checker: Checker, value: Expression, at: tree.Node) -> Expression:
    """Return a position or a length, which the standard allows to be any integer, as an INT that no cut has changed."""
    kind = value.type
    if type(value) is Untyped or not is_number(kind) or kind is Elementary.INT:
        return value
    if kind.low >= Elementary.INT.low and kind.high <= Elementary.INT.high:
        return constants.converted(value, Elementary.INT)
    low, high = max(kind.low, -1), min(kind.high, Elementary.INT.high)
    limited = of_values(checker, "LIMIT", [Constant(low, kind), value, Constant(high, kind)], at)
    assert limited is not None
    return constants.converted(limited, Elementary.INT)


def _cut(value: Expression, kind: Type) -> Expression:
    """Return a text that is no longer than the parameter: the functions for strings know 255 characters."""
    given = value.type
    is_longer = isinstance(given, StringType) and isinstance(kind, StringType) and given.length > kind.length
    return constants.converted(value, kind) if is_longer else value


def _operator_call(
    checker: Checker, name: str, operator: Operator, values: Sequence[Expression], at: tree.Node
) -> Expression | None:
    """ADD(a, b, c) is a + b + c, and GT(a, b, c) is a > b AND b > c."""
    if operator is Operator.NOT and len(values) == 1:
        return checker.negate(operator, values[0], at)
    is_binary = operator.name in intrinsics.BINARY_ONLY
    if operator is Operator.NOT or len(values) < 2 or (is_binary and len(values) != 2):
        expected = (
            "one argument" if operator is Operator.NOT else "two arguments" if is_binary else "two arguments or more"
        )
        checker.context.say(at, f"{name} with {len(values)} arguments", expected)
        return None
    if operator not in COMPARISONS:
        result: Expression | None = values[0]
        for value in values[1:]:
            result = checker.operate(operator, result, value, at) if result is not None else None
        return result
    result = checker.operate(operator, values[0], values[1], at)
    for left, right in pairwise(values[1:]):
        step = checker.operate(operator, left, right, at)
        result = checker.operate(Operator.AND, result, step, at) if result is not None and step is not None else None
    return result
