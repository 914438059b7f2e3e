"""Calls in expressions: functions of the project and of libraries, standard functions, and ADR, SIZEOF, INDEXOF."""

import re
from collections.abc import Callable, Collection, Iterator, Sequence
from itertools import pairwise
from typing import Final, TypeGuard

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    access,
    constants,
    enable,
    implicit,
    methods,
    open_arrays,
    places,
    references,
    registers,
    writing,
)
from fieldrig_devices.iec.check.arguments import Arguments, match_arguments, reference
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context, place_of
from fieldrig_devices.iec.check.project import start_of
from fieldrig_devices.iec.check.sizes import Sizes
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.check.untyped import Untyped, integer
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.library import conversions, fixed, intrinsics, templates
from fieldrig_devices.iec.library.timed import TIMED
from fieldrig_devices.iec.program import (
    COMPARISONS,
    AddressOf,
    CallFunction,
    Cell,
    Constant,
    Enabled,
    Expression,
    Load,
    Operator,
    Place,
    Pou,
    Space,
    Target,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import ArrayType, PointerType, StringType, StructType, Type


def value(checker: Checker, node: tree.Call, wanted: Type | None) -> Expression | None:
    """Return the result of a call in an expression; None after a message."""
    context = checker.context
    method = methods.find(checker, node.called)
    if method is not None:
        return _method_value(checker, node, *method)
    called = places.without_library(context, node.called)
    if not isinstance(called, tree.Name):
        if checker.meaning(node.called) is None:
            return None
        context.say(node, f"the call of {text(node.called)} has no result", "a function", _pin_hint(text(node.called)))
        return None
    name = called.text
    entity = context.find(name)
    if entity is None or isinstance(entity, Variable):
        function = called_function(context, name)
        if function is not None:
            return _function_value(checker, node, function, wanted)
    if isinstance(entity, Pou) and entity.kind is PouKind.FUNCTION:
        return _function_value(checker, node, entity, wanted)
    if entity is not None:
        hint = _pin_hint(name) if isinstance(entity, Variable) else f"declare an instance: x : {name};"
        context.say(node, f"{name} is not a function", "a function", hint)
        return None
    if name.upper() in open_arrays.FUNCTIONS and context.project.dialect.has_open_arrays:
        return open_arrays.bound(checker, node, wanted)
    special = SPECIAL.get(name.upper())
    if special is not None and (context.project.dialect.has_references or name.upper() not in references.FUNCTIONS):
        return special(checker, node)
    if intrinsics.is_standard(name):
        return _standard_call(checker, name.upper(), node, wanted)
    if context.project.lacks_base(context.block):
        return None
    functions = [known for known, pou in context.project.pous.items() if pou.kind is PouKind.FUNCTION]
    hint = context.project.reports.closest(name, functions)
    context.say(node, f"the function {name} is not declared", "" if hint else "a declared or standard function", hint)
    return None


def _function_value(checker: Checker, node: tree.Call, function: Pou, wanted: Type | None) -> Expression | None:
    if function.result is not None:
        made = call(checker, function, node)
        source = checker.context.project.sources.get(function)
        is_of_any_type = source is not None and source.is_library and function.name in _OF_ANY_INTEGER
        is_wanted = is_of_any_type and wanted is not None and _is_number(wanted)
        return constants.converted(made, wanted) if made is not None and is_wanted and wanted is not None else made
    if checker.context.project.dialect.has_void_functions:  # otherwise its declaration has the message
        expected = f"a function with a type, FUNCTION {function.name} : INT"
        checker.context.say(node, f"the function {function.name} has no result", expected)
    return None


_OF_ANY_INTEGER: Final = frozenset({"DAY_OF_WEEK"})
"""Functions of the libraries whose result is an integer of any type, small enough for each."""


def _method_value(checker: Checker, node: tree.Call, instance: Place | None, method: Pou) -> Expression | None:
    if method.result is not None:
        return call(checker, method, node, instance)
    checker.context.say(node, f"the method {method.name} has no result", "a method with a type, METHOD name : INT")
    return None


def _pin_hint(name: str) -> str:
    return f"call {name}(...); as a statement first, and read {name}.Q afterwards"


def called_function(context: Context, name: str) -> Pou | None:
    """Return the function that is called within itself, where its name is also its result."""
    owner = context.owner
    is_itself = owner is not None and owner.kind is PouKind.FUNCTION and context.key(name) == context.key(owner.name)
    return owner if is_itself else None


def note_call(context: Context, pou: Pou, node: tree.Node) -> None:
    if context.pou is not None:
        context.project.calls.setdefault(context.pou, {}).setdefault(pou, place_of(node))


def call(checker: Checker, pou: Pou, node: tree.Call, instance: Place | None = None) -> CallFunction | Enabled | None:
    """Check a call of a FUNCTION or a method with its arguments, which may be given by position or by name."""
    if not access.allows_call(checker, node, instance, pou):
        return None
    note_call(checker.context, pou, node)
    parts = enable.split(checker, node, pou)
    made = _call(checker, pou, parts[0], instance) if parts is not None else None
    if made is None or parts is None or parts[1] is enable.ALWAYS:
        return made
    return Enabled(made, parts[1])


def _call(checker: Checker, pou: Pou, node: tree.Call, instance: Place | None) -> CallFunction | None:
    source = checker.context.project.sources[pou]
    matched = match_arguments(checker, node, pou, source.inputs, source.outputs)
    if matched is None:
        return None
    inputs = _inputs(checker, pou, matched, source.inputs)
    arrays = _output_arrays(checker, matched, source.outputs, node)
    outputs = _outputs(checker, pou, matched)
    if inputs is None or arrays is None or outputs is None:
        return None
    kind = pou.result.type if pou.result is not None else Elementary.BOOL
    return CallFunction(pou, (*inputs, *arrays), kind, outputs, instance)


def _is_part_of_a_date(context: Context, pou: Pou, variable: Variable) -> bool:
    """True for a parameter of CONCAT_DATE, SPLIT_DATE and their kin, which is an integer of any type."""
    source = context.project.sources.get(pou)
    return source is not None and source.is_library and variable.type is Elementary.LINT


def _goes_into(context: Context, pou: Pou, variable: Variable, kind: Type) -> bool:
    """True if the value of an output goes into a target of this type by itself."""
    allowed = implicit.WIDENS if context.mixes_integers else implicit.STRICT
    is_part = _is_number(kind) and _is_part_of_a_date(context, pou, variable)
    return kind == variable.type or is_part or (variable.type, kind) in allowed


def _outputs(checker: Checker, pou: Pou, matched: Arguments) -> tuple[tuple[Variable, Place, bool], ...] | None:
    """Check the targets of outputs, which have the types of these; None after a message."""
    made: list[tuple[Variable, Place, bool]] = []
    for variable, given, is_negated in matched.outputs:
        place = checker.target(given)
        if place is not None and not _goes_into(checker.context, pou, variable, place.type):
            hint = "an output goes into its own type, or into one that has all of its values"
            checker.context.say(given, f"{text(given)} is {a(place.type)}", str(variable.type), hint)
        elif place is not None and (not is_negated or checker.negate(Operator.NOT, Load(place), given) is not None):
            made.append((variable, place, is_negated))
    return tuple(made) if len(made) == len(matched.outputs) else None


def _inputs(
    checker: Checker, pou: Pou, matched: Arguments, variables: Sequence[Variable]
) -> list[tuple[Variable, Expression | Place]] | None:
    made: list[tuple[Variable, Expression | Place]] = []
    is_whole = True
    for variable in variables:
        given = matched.inputs.get(variable)
        argument: Expression | Place | None
        if given is None:
            argument = _default(checker.context, variable)
        elif variable.is_reference:
            argument = reference(checker, given, variable)
        elif _is_part_of_a_date(checker.context, pou, variable):
            argument = _any_integer(checker, given)
        else:
            argument = checker.expression_as(given, variable.type)
        if argument is None:
            is_whole = False
        else:
            made += [(variable, argument), *_limits(variable, argument)]
    return made if is_whole else None


def _any_integer(checker: Checker, node: tree.Expression) -> Expression | None:
    """Return an integer of any type as a LINT."""
    value = checker.expression(node)
    if value is None or type(value) is Untyped or not _is_number(value.type):
        return checker.convert(value, Elementary.LINT, node) if value is not None else None
    return constants.converted(value, Elementary.LINT)


def _limits(variable: Variable, argument: Expression | Place) -> Iterator[tuple[Variable, Expression]]:
    return open_arrays.limits(variable, argument) if isinstance(argument, Place) else iter(())


def _output_arrays(
    checker: Checker, matched: Arguments, outputs: Sequence[Variable], node: tree.Call
) -> list[tuple[Variable, Expression | Place]] | None:
    """Take the outputs that are ARRAY[*] out of the arguments, since the function writes into these arrays."""
    given = {variable: target for variable, target, _ in matched.outputs if open_arrays.is_open(variable)}
    matched.outputs = [output for output in matched.outputs if output[0] not in given]
    made: list[tuple[Variable, Expression | Place]] = []
    is_whole = True
    for variable in outputs:
        target = given.get(variable)
        place = reference(checker, target, variable) if target is not None else None
        if place is not None:
            made += [(variable, place), *open_arrays.limits(variable, place)]
        elif open_arrays.is_open(variable):
            is_whole = False
            if target is None:
                what = f"the output {variable.name} is missing in the call of {text(node.called)}"
                checker.context.say(node, what, f"{variable.name} => array")
    return made if is_whole else None


def _default(context: Context, variable: Variable) -> Expression | None:
    """Return what an input has that a call does not give."""
    project = context.project
    start = project.constant_of(variable)
    if start is not None:
        return Constant(start, variable.type)
    if isinstance(variable.type, PointerType):
        return Constant(0, variable.type)
    if not isinstance(variable.type, StructType | ArrayType):
        return None
    name = f"$start of {variable.type}: {variable.initial!r}"
    made = project.globals.get(context.key(name))
    if made is None:
        made = Variable(name, variable.type, Space.GLOBAL, Section.GLOBAL, variable.initial, is_constant=True)
        project.globals[context.key(name)] = made
    return Load(Cell(made, made.type))


# ---- standard functions


def _standard_call(checker: Checker, name: str, node: tree.Call, wanted: Type | None) -> Expression | None:
    parts = enable.split(checker, node, None)
    given = _in_order(checker.context, name, parts[0]) if parts is not None else None
    if given is None or parts is None:
        return None
    inner = wanted_inside(name, wanted)
    values = [checker.expression(argument, inner) if argument is not None else None for argument in given]
    if any(value is None and argument is not None for value, argument in zip(values, given, strict=True)):
        return None
    whole = _with_defaults(checker.context, name, values, node)
    nodes = [argument or node for argument in given]
    call = standard(checker, name, whole, node, wanted, nodes) if whole is not None else None
    return enable.result(checker, call, parts[1], wanted, node) if call is not None else None


def wanted_inside(name: str, wanted: Type | None) -> Type | None:
    """Return the type that the surroundings of arguments have: REAL in REAL_TO_INT(EXPT(a, b))."""
    pair = conversions.pair(name)
    return pair[0] if pair is not None else wanted


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


def standard(
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
    if name in TIMED:
        return _timed(checker, name, values, at, nodes)
    if name in ("SEL", "MUX") and values and isinstance(values[-1].type, StructType | ArrayType):
        return _selected(checker, name, values, at)
    if name in templates.SHIFTS:
        values = [*values[:1], *map(_steps, values[1:])]
    name, values = registers.conversion(name, values)
    values, power = registers.powers(checker.context, values, wanted) if name == "EXPT" else (values, None)
    is_of_standard = name in fixed.ON_TEXTS and not checker.context.mixes_integers
    if is_of_standard:
        values = [_position(checker, value, at) for value in values]
    kinds = [value.argument if type(value) is Untyped else value.type for value in values]
    time = checker.context.project.dialect.time
    overload = intrinsics.find(conversions.of_dialect(name, time), kinds, wanted)
    if isinstance(overload, str):
        head, _, rest = overload.replace(time.name, str(time)).partition(": expected ")
        expected, _, got = rest.rpartition(", got ")
        checker.context.say(at, f"{head} with {got}" if got else overload, expected)
        return None
    if not checker.context.mixes_integers:
        overload = intrinsics.transferring(overload)
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
    if made.type is Elementary.TIME or power is not None:
        return constants.converted(made, power or time)
    is_length = is_of_standard and made.type is Elementary.INT
    return constants.converted(made, wanted) if is_length and wanted is not None and _is_number(wanted) else made


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
    return context.project.dialect.time if kind is Elementary.TIME else kind


def _selected(checker: Checker, name: str, values: Sequence[Expression], at: tree.Node) -> Expression | None:
    """Return what SEL or MUX of structures or arrays selects: the variable with the address that is selected."""
    kind, addresses = values[-1].type, list[Expression]()
    for value in values[1:]:
        if value.type != kind or not isinstance(value, Load):
            checker.context.say(at, f"{name} with {a(value.type)} beside {a(kind)}", "variables of the same type")
            return None
        address = address_of(checker, value.place, at)
        if address is None:
            return None
        addresses.append(address)
    selection = standard(checker, name, [values[0], *addresses], at)
    return Load(Target(selection, kind)) if selection is not None else None


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
    made = standard(checker, name, whole, at, parameters[-1], nodes) if whole is not None else None
    return made if made is not None and made.type in constants.REGISTER.values() else None


def _steps(value: Expression) -> Expression:
    """Return the number of bits of a shift, which is any integer, as a DWORD."""
    is_integer = isinstance(value.type, Elementary) and value.type.is_integer
    return constants.converted(value, Elementary.DWORD) if is_integer and type(value) is not Untyped else value


def _is_number(kind: Type) -> TypeGuard[Elementary]:
    """True for the ANY_INT of the standard."""
    return isinstance(kind, Elementary) and kind.family in (Family.SIGNED, Family.UNSIGNED)


def _position(checker: Checker, value: Expression, at: tree.Node) -> Expression:
    """Return a position or a length, which the standard allows to be any integer, as an INT that no cut has changed."""
    kind = value.type
    if type(value) is Untyped or not _is_number(kind) or kind is Elementary.INT:
        return value
    if kind.low >= Elementary.INT.low and kind.high <= Elementary.INT.high:
        return constants.converted(value, Elementary.INT)
    low, high = max(kind.low, -1), min(kind.high, Elementary.INT.high)
    limited = standard(checker, "LIMIT", [Constant(low, kind), value, Constant(high, kind)], at)
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


# ---- ADR, SIZEOF, INDEXOF


def _one_argument(checker: Checker, node: tree.Call) -> tree.Expression | None:
    if len(node.arguments) == 1 and node.arguments[0].value is not None:
        return node.arguments[0].value
    checker.context.say(node, f"{text(node.called)} with {len(node.arguments)} arguments", "one argument")
    return None


def address_of(checker: Checker, place: Place, at: tree.Node) -> Expression | None:
    """Return the address of a checked place, as a DWORD (PD-358)."""
    if not writing.has_cell(place):
        checker.context.say(
            at,
            f"{text(at)} has no address of its own",
            "a variable",
            "copy it into a variable first",
        )
        return None
    return AddressOf(place, Elementary.DWORD)


def _adr(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    place = _cell_of(checker, given) if given is not None else None
    return address_of(checker, place, given) if place is not None and given is not None else None


def _cell_of(checker: Checker, node: tree.Expression) -> Place | None:
    """The place of an argument, also of a constant, which has a cell too."""
    entity = checker.context.find(node.text) if isinstance(node, tree.Name) else None
    if isinstance(entity, Variable) and entity.is_constant:
        return Cell(entity, entity.type)
    return checker.place(node)


def _sizeof(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    if given is None:
        return None
    if isinstance(given, tree.Name) and checker.context.find(given.text) is None:
        kind = checker.context.project.named_type(given.text)
        if kind is not None:
            return _size(checker, given, kind)
    value = checker.expression(given)
    return _size(checker, given, value.type) if value is not None else None


def _size(checker: Checker, at: tree.Node, kind: Type) -> Expression | None:
    if kind in checker.context.project.unfinished:
        checker.context.say(at, f"the size of {kind} depends on itself", "the size of another type")
        return None
    return integer(Sizes(checker.context.project).of(kind))


def _indexof(checker: Checker, node: tree.Call) -> Expression | None:
    given = _one_argument(checker, node)
    meaning = checker.meaning(given) if given is not None else None
    if meaning is None or given is None:
        return None
    if not isinstance(meaning, Pou):
        checker.context.say(given, f"{text(given)} is not a POU", "a program, function or function block")
        return None
    return integer(list(checker.context.project.pous.values()).index(meaning))


SPECIAL: Final[dict[str, Callable[[Checker, tree.Call], Expression | None]]] = {
    "ADR": _adr,
    "SIZEOF": _sizeof,
    "INDEXOF": _indexof,
    **references.FUNCTIONS,
}
