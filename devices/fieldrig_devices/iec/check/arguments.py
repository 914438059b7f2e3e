"""Arguments of calls: which parameter each belongs to, and what may be passed to a VAR_IN_OUT."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import dispatch, enable, open_arrays
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import Pins
from fieldrig_devices.iec.check.texts import a, listed, text
from fieldrig_devices.iec.elementary import Elementary, Family
from fieldrig_devices.iec.program import (
    AddressOf,
    Binary,
    Bit,
    Cell,
    Component,
    Constant,
    Element,
    Kept,
    Load,
    Located,
    OpenElement,
    Parameter,
    Place,
    Pou,
    Result,
    Space,
    Target,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import EnumType, ObjectType, OpenArrayType, PointerType, StringType, Type

_ALIKE: Final = {Family.BITS, Family.UNSIGNED}
"""Types of one size in these families have the same numbers in the same bytes."""


@dataclass(slots=True)
class Arguments:
    inputs: dict[Variable, tree.Expression] = field(default_factory=dict)
    outputs: list[tuple[Variable, tree.Expression, bool]] = field(default_factory=list)
    """(output, target, is negated)."""


def match_arguments(
    checker: Checker, node: tree.Call, pou: Pou, inputs: Sequence[Variable], outputs: Sequence[Variable]
) -> Arguments | None:
    """Return the arguments by parameter; None after a message about the call as a whole."""
    matched = Arguments()
    is_whole = True
    pins = _pins(checker.context, pou, inputs, outputs)
    for position, argument in enumerate(node.arguments):
        named = pins.outputs.get(checker.context.key(argument.name)) if argument.name else None
        placed = pins.placed[position] if not argument.name and position < len(pins.placed) else None
        if placed is not None and placed.section is Section.OUTPUT and argument.value is not None:
            matched.outputs.append((placed, argument.value, False))
        elif argument.is_output or named is not None:
            is_whole = _output(checker, argument, pou, named, pins, matched) and is_whole
        elif argument.value is not None:
            parameter = _parameter(checker, argument, position, pou, pins)
            if parameter is not None and parameter in matched.inputs:
                what = f"the argument {parameter.name} is given twice"
                if checker.context.project.dialect.repeats_arguments and argument.name:
                    checker.context.note(argument, f"{what}, and this value counts", "remove the other one")
                else:
                    checker.context.say(argument, what, "one value for each input")
                    parameter = None
            if parameter is None:
                is_whole = False
            else:
                matched.inputs[parameter] = argument.value
    return matched if is_whole and not _misses(checker, node, pou, inputs, matched) else None


def _pins(context: Context, pou: Pou, inputs: Sequence[Variable], outputs: Sequence[Variable]) -> Pins:
    """Return the parameters of a call.  They are worked out once, as a call may have few arguments for many of them."""
    known, form = context.project.pins, (pou, len(inputs), len(outputs))
    if form not in known:
        own, is_by_position = {*inputs, *outputs}, context.project.dialect.has_calls_by_position
        known[form] = Pins(
            {context.key(variable.name): variable for variable in inputs},
            {context.key(variable.name): variable for variable in outputs},
            [variable for variable in pou.variables.values() if variable in own] if is_by_position else inputs,
        )
    return known[form]


def _output(
    checker: Checker, argument: tree.Argument, pou: Pou, variable: Variable | None, pins: Pins, matched: Arguments
) -> bool:
    context = checker.context
    if variable is None and context.project.lacks_base(pou):
        return False
    if variable is None:
        names = listed(output.name for output in pins.outputs.values()) or "no output"
        what = f"{pou.name} has no output {argument.name}"
        context.say(argument, what, names, enable.hint(context, argument.name))
        return False
    if not argument.is_output:
        context.say(argument, f"{variable.name} is an output of {pou.name}", f"{variable.name} => target")
        return False
    if argument.value is not None:
        matched.outputs.append((variable, argument.value, argument.is_negated))
    return True


def _parameter(
    checker: Checker,
    argument: tree.Argument,
    position: int,
    pou: Pou,
    pins: Pins,
) -> Variable | None:
    """Return the input of an argument."""
    context = checker.context
    is_by_position = context.project.dialect.has_calls_by_position
    compared = _compared(checker, argument, pins, is_certain=pou.kind is not PouKind.FUNCTION and not is_by_position)
    if compared is not None:
        value = text(argument.value) if argument.value is not None else ""
        context.say(argument, f"{value} is a comparison", compared, "A value is passed with :=.")
        return None
    if argument.name:
        parameter = pins.inputs.get(context.key(argument.name))
        if parameter is None and not context.project.lacks_base(pou):
            names = [variable.name for variable in pins.inputs.values()]
            hint = enable.hint(context, argument.name) or context.project.reports.closest(argument.name, names)
            what = f"{pou.name} has no input {argument.name}"
            context.say(argument, what, listed(names) or "no argument", hint)
        return parameter
    if pou.kind is not PouKind.FUNCTION and not is_by_position:
        first = next(iter(pins.inputs.values()), None)
        example = f"{first.name} := {text(argument.value) if argument.value else '...'}" if first else "no argument"
        context.say(argument, f"{pou.name} is called with an argument without a name", example)
        return None
    if position >= len(pins.placed):
        if position == len(pins.placed):
            context.say(argument, f"too many arguments for {pou.name}", f"{len(pins.inputs)} arguments")
        return None
    return pins.placed[position]


def _compared(checker: Checker, argument: tree.Argument, pins: Pins, *, is_certain: bool) -> str | None:
    """Return the argument that `IN = TRUE` means, if IN is an input, and no variable of the caller or `is_certain`."""
    match argument:
        case tree.Argument(name="", value=tree.Binary(operator="=", left=tree.Name(text=name), right=right)):
            if checker.context.key(name) in pins.inputs and (is_certain or checker.context.find(name) is None):
                return f"{name} := {text(right)}"
    return None


def _misses(checker: Checker, node: tree.Call, pou: Pou, inputs: Sequence[Variable], matched: Arguments) -> bool:
    """A function needs every input without a declared start value, or none in a formal call of edition 3.

    A block needs only its VAR_IN_OUT.
    """
    is_formal = all(argument.name or argument.is_output for argument in node.arguments)
    may_miss = is_formal and checker.context.project.dialect.allows_missing_inputs
    missing = [
        variable.name
        for variable in inputs
        if variable not in matched.inputs
        and (
            variable.section is Section.IN_OUT
            or (pou.kind is PouKind.FUNCTION and not may_miss and not checker.context.project.has_start(variable))
            or (pou.kind is PouKind.FUNCTION and (variable.is_reference or isinstance(variable.type, ObjectType)))
        )
    ]
    if missing:
        what = (
            f"the argument {missing[0]} is missing"
            if len(missing) == 1
            else f"the arguments {', '.join(missing)} are missing"
        )
        all_names = ", ".join(variable.name for variable in inputs)
        checker.context.say(node, f"{what} in the call of {pou.name}", f"values for {all_names}")
    return bool(missing)


def reference(checker: Checker, node: tree.Expression, variable: Variable) -> Place | None:
    """Return the argument of a VAR_IN_OUT or an ARRAY[*], which is passed by its address (PD-352)."""
    context, section = checker.context, variable.section.value
    if variable.is_constant and (kept := _constant(checker, node, variable)) is not None:
        return kept
    is_value = isinstance(node, tree.Literal | tree.Unary | tree.Binary)
    place = None
    if isinstance(node, tree.Call):  # checked once, or the work would double with each call inside another one
        result = checker.expression(node)
        if result is None:
            return None
        is_value = not isinstance(result, Load) or isinstance(result.place, Kept)
        place = result.place if isinstance(result, Load) else None
    elif not is_value:
        meaning = checker.meaning(node)
        if meaning is None:
            return None
        is_value = isinstance(meaning, Constant) or _is_of_result(meaning)
        place = checker.place(node) if not is_value else None
    if is_value or _is_of_result(place):
        context.say(
            node,
            f"{text(node)} is passed to the {section} {variable.name}",
            "a variable",
            "store the value in a variable first",
        )
        return None
    if place is None:
        return None
    is_bit = isinstance(place, Bit) or (isinstance(place, Located) and place.bit >= 0)
    if is_bit or isinstance(place, Parameter):
        what = "a located BOOL" if isinstance(place, Located) else "a bit" if is_bit else "a parameter"
        context.say(
            node,
            f"{text(node)} is {what} and has no address for the {section} {variable.name}",
            "a variable without AT (PD-352)",
            "copy it into a variable before the call and back after it",
        )
        return None
    if variable.section is not Section.INPUT and not variable.is_constant and (fixed := _fixed(place)):
        context.say(
            node, f"{text(node)} is {fixed} and {variable.name} may be changed", "a variable that may be written"
        )
        return None
    is_text = variable.is_constant and _is_text(place.type, variable.type)
    if not is_text and not _fits(context, place.type, variable.type):
        context.say(
            node,
            f"{text(node)} is {a(place.type)}",
            f"a variable of type {variable.type} for the {section} {variable.name}",
        )
        return None
    return place


def _constant(checker: Checker, node: tree.Expression, variable: Variable) -> Place | None:
    """Return a hidden variable with a constant that is passed to a VAR_IN_OUT CONSTANT; None for other arguments."""
    if isinstance(node, tree.Call) or not isinstance(variable.type, Elementary | StringType | EnumType):
        return None
    is_named = isinstance(node, tree.Name | tree.Member)
    if is_named and not isinstance(checker.meaning(node), Constant):
        return None
    if isinstance(node, tree.Index | tree.Dereference | tree.BitOf | tree.Direct):
        return None
    value = checker.expression_as(node, variable.type)
    if not isinstance(value, Constant):
        return None
    wanted = value.type if isinstance(value.type, StringType) else variable.type
    name = f"$constant{len(checker.context.project.globals)}"
    made = Variable(name, wanted, Space.GLOBAL, Section.GLOBAL, value.value, is_constant=True)
    checker.context.project.globals[checker.context.key(name)] = made
    return Cell(made, wanted)


def _is_text(given: Type, wanted: Type) -> bool:
    return isinstance(given, StringType) and isinstance(wanted, StringType) and given.is_wide is wanted.is_wide


def _is_of_result(place: object) -> bool:
    """True for a part of the result of a call, whose memory the next call takes."""
    while True:
        match place:
            case Component(of=of) | Element(of=of) | OpenElement(of=of) | Bit(of=of):
                place = of
            case Target(AddressOf(place=of)) | Target(Binary(left=AddressOf(place=of))):  # a part of a union
                place = of
            case _:
                return isinstance(place, Result)


def _fixed(place: Place) -> str:
    """Return what a place is that no code may change; empty for other places."""
    while isinstance(place, Element | OpenElement) or (isinstance(place, Component) and place.variable is None):
        place = place.of
    if not isinstance(place, Cell):  # a constant of a block is a cell too, which all instances share
        return ""
    variable = place.variable
    if variable.is_constant or variable.is_fixed:
        return "a constant"
    is_shared = variable.section is Section.INPUT and open_arrays.is_open(variable)
    return "a part of the VAR_INPUT, of which there is no copy," if is_shared else ""


def _fits(context: Context, given: Type, wanted: Type) -> bool:
    """True for the same type, any array for an ARRAY[*], a longer text, and an enumeration where integers mix.

    An instance may be one of a function block that extends the wanted one.
    """
    if isinstance(wanted, OpenArrayType):
        return open_arrays.fits(given, wanted)
    if isinstance(given, EnumType) and context.mixes_integers:
        return wanted in (given, given.base)
    dialect = context.project.dialect
    if isinstance(given, PointerType) and wanted == PointerType(Elementary.BYTE) and dialect.passes_any_pointer:
        return not given.is_reference  # PVOID
    if isinstance(given, Elementary) and isinstance(wanted, Elementary) and dialect.passes_alike:
        return given == wanted or (given.size == wanted.size and {given.family, wanted.family} == _ALIKE)
    return given == wanted or _is_longer_text(given, wanted) or dispatch.derives(context.project, given, wanted)


def _is_longer_text(given: Type, wanted: Type) -> bool:
    return _is_text(given, wanted) and given.size >= wanted.size
