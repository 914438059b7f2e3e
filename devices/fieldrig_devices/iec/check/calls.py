"""Calls in expressions: functions of the project and of libraries; `standard` and `special` have the others."""

from collections.abc import Iterator, Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import (
    access,
    constants,
    enable,
    heap,
    library_names,
    methods,
    open_arrays,
    references,
    special,
    standard,
)
from fieldrig_devices.iec.check.arguments import Arguments, match_arguments, reference
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import OUTSIDE, Context, position_of
from fieldrig_devices.iec.check.texts import text
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.program import (
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
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import ArrayType, PointerType, StructType, Type
from fieldrig_devices.languages.mistakes import Code


def value(checker: Checker, node: tree.Call, wanted: Type | None) -> Expression | None:
    """Return the result of a call in an expression; None after a message."""
    context = checker.context
    extension = context.extension
    if extension is not None and extension.has_value(node):
        return extension.value(checker, node)
    method = methods.find(checker, node.called)
    if method is not None:
        return _method_value(checker, node, *method)
    called = library_names.without_library(context, node.called)
    if not isinstance(called, tree.Name):
        if checker.meaning(node.called) is None:
            return None
        context.say(node, f"the call of {text(node.called)} has no result", "a function", _pin_hint(text(node.called)))
        return None
    entity, name = context.find(called.text), called.text.removeprefix(OUTSIDE)
    if entity is None or isinstance(entity, Variable):
        function = called_function(context, name)
        if function is not None:
            return _function_value(checker, node, function, wanted)
    if isinstance(entity, Pou) and entity.kind is PouKind.FUNCTION:
        return _function_value(checker, node, entity, wanted)
    if entity is not None and not _means_standard(context, entity, name):
        hint = _pin_hint(name) if isinstance(entity, Variable) else f"declare an instance: x : {name};"
        context.say(node, f"{name} is not a function", "a function", hint)
        return None
    if name.upper() in open_arrays.FUNCTIONS and context.project.dialect.has_open_arrays:
        return open_arrays.bound(checker, node, wanted)
    if name.upper() == heap.NEW and context.project.dialect.has_heap:
        made = heap.call_of(checker, node)
        return call(checker, *made) if made is not None else None
    rule = special.SPECIAL.get(name.upper())
    if rule is not None and (context.project.dialect.has_references or name.upper() not in references.FUNCTIONS):
        return rule(checker, node)
    if intrinsics.is_standard(name):
        return standard.call(checker, name.upper(), node, wanted)
    if context.project.lacks_base(context.block):
        return None
    if context.is_type(name):
        hint = f"{name}#... gives a number its type, and ..._TO_{name}(...) converts a value"
        context.say(node, f"{name} is a type", "a function", hint if name.upper() in Elementary.__members__ else "")
        return None
    functions = [known for known, pou in context.project.pous.items() if pou.kind is PouKind.FUNCTION]
    hint = context.project.reports.closest(name, [*functions, *intrinsics.alike(name)])
    expected = "" if hint else "a declared or standard function"
    context.say(node, f"the function {name} is not declared", expected, hint, Code.NO_FUNCTION, name)
    return None


def _means_standard(context: Context, entity: object, name: str) -> bool:
    """True for a call of a standard function whose name a value, such as one of an enumeration, has too."""
    if isinstance(entity, Pou):
        return False
    is_special = name.upper() in special.SPECIAL and name.upper() not in references.FUNCTIONS
    return is_special or intrinsics.is_standard(name)


def _function_value(checker: Checker, node: tree.Call, function: Pou, wanted: Type | None) -> Expression | None:
    if function.result is not None:
        made = call(checker, function, node)
        source = checker.context.project.sources.get(function)
        is_of_any_type = source is not None and source.is_library and function.name in _OF_ANY_INTEGER
        is_wanted = is_of_any_type and wanted is not None and standard.is_number(wanted)
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
        context.project.calls.setdefault(context.pou, {}).setdefault(pou, position_of(node))


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


def _outputs(checker: Checker, pou: Pou, matched: Arguments) -> tuple[tuple[Variable, Place, Expression], ...] | None:
    """Check the targets of outputs, which are assigned like those of a statement; None after a message."""
    made: list[tuple[Variable, Place, Expression]] = []
    for variable, given, is_negated in matched.outputs:
        place = checker.target(given)
        value: Expression | None = Load(Cell(variable, variable.type))
        if is_negated and value is not None:
            value = checker.negate(Operator.NOT, value, given)
        if place is not None and value is not None:
            if standard.is_number(place.type) and _is_part_of_a_date(checker.context, pou, variable):
                value = constants.converted(value, place.type)
            else:
                value = checker.convert(value, place.type, tree.Name(variable.name, position=given.position))
        if place is not None and value is not None:
            made.append((variable, place, value))
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
    if value is None or type(value) is Untyped or not standard.is_number(value.type):
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
