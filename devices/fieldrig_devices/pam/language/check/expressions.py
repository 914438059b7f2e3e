"""The types of expressions: a flag, an integer, a real or a text (section 1.5 of the digest).

An expression whose type cannot be known, because something in it is wrong or a formal parameter, is None, which fits
everywhere.
"""

from collections.abc import Mapping, Sequence
from typing import Final

from fieldrig.points.values import counted
from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.check.constants import constant
from fieldrig_devices.pam.language.check.symbols import TYPE_NAMES, Context, Names, Symbol, listed, with_article
from fieldrig_devices.pam.language.functions import EXECUTIVE, INQUIRIES, MATHEMATICS, VALUES, Function, Type
from fieldrig_devices.pam.language.objects import KINDS, PORT_PARAMETERS, Rule

NUMERIC: Final = ("integer", "real")
_COMPARISONS: Final = ("=", "<>", "<", "<=", ">", ">=")


def type_of(expression: tree.Expression, names: Names, context: Context) -> Type | None:
    """Return the type of an expression.  Everything that is wrong in it is reported."""
    match expression:
        case tree.Number(value=value):
            return "integer" if isinstance(value, int) else "real"
        case tree.Text():
            return "text"
        case tree.Word():
            return _word(expression, names)
        case tree.Reference():
            return _value(expression, names, context)
        case tree.ParameterOf():
            return _parameter(expression, names, context)
        case tree.Unary():
            return _unary(expression, names, context)
        case tree.Binary():
            return _binary(expression, names, context)
        case tree.Inquiry():
            return _inquiry(expression, names, context)
        case tree.Reduction(operand=operand):
            need(operand, "flag", names, context.reduced())
            return "flag"


def need(expression: tree.Expression, wanted: Type, names: Names, context: Context) -> None:
    """Report an expression that is not of the wanted type.  Integers and reals are converted (PAML-227)."""
    own_type = type_of(expression, names, context)
    if own_type is None or own_type == wanted or (own_type in NUMERIC and wanted in NUMERIC):
        return
    if wanted == "flag" and is_bit(expression):
        return
    names.wrong(expression.place, f"this is {TYPE_NAMES[own_type]}", TYPE_NAMES[wanted])


def is_bit(expression: tree.Expression) -> bool:
    """True for the numbers 0 and 1, which listings use for flags (manual line 5775)."""
    return isinstance(expression, tree.Number) and expression.value in (0, 1) and isinstance(expression.value, int)


def indexed(
    reference: tree.Reference, symbol: Symbol, names: Names, context: Context, *, is_target: bool = False
) -> None:
    """Report an index that does not fit the object or the place (PAML-245, PAML-246, G-42)."""
    index = reference.index
    if not symbol.is_multiple:
        if index is not None:
            names.wrong(reference.place, f"{symbol.name} has one item only", f"{symbol.name} without [{index}]")
        return
    if index is None and symbol.has_one_item:
        return
    if index is None:
        hint = "[i] is the present item, [all] means each of them, [all+] is OR and [all*] is AND."
        names.wrong(reference.place, f"{symbol.name} has several items", "an index", hint)
    elif index == "i" and not (context.is_multiple or context.is_reduced):
        hint = "The task, actions or equation around it needs NUMBER, NODES_GROUP or [i]."
        names.wrong(
            reference.place, "[i] is used where there is no present item", "[all]" if is_target else "[all+]", hint
        )
    elif is_target and index in ("all+", "all*"):
        names.wrong(reference.place, f"[{index}] cannot be changed", "[i] or [all]")
    elif not is_target and index == "all":
        names.wrong(reference.place, "[all] has no value", "[all+] or [all*]", "[all+] is OR, [all*] is AND.")


def _word(word: tree.Word, names: Names) -> Type | None:
    if word.name == "TIMEOUT":
        return "flag"
    if word.name == "PI":
        return "real"
    names.wrong(word.place, f"{word.name} cannot be a value in an expression", "a number, a flag or an object")
    return None


def _value(reference: tree.Reference, names: Names, context: Context) -> Type | None:
    if reference.name in context.formals:
        return None
    symbol = names.object(reference)
    if symbol is None:
        return None
    indexed(reference, symbol, names, context)
    if symbol.kind == "ENCODER":
        _takes_time(reference.place, names, context)
    value_type = VALUES.get(symbol.kind)
    if value_type is None:
        asked = sorted(INQUIRIES.get(symbol.kind, {}))
        hint = f"Ask it with ?: {listed(asked)}." if asked else ""
        names.wrong(reference.place, f"{with_article(symbol.kind)} has no value of its own", "an inquiry", hint)
    elif reference.index in ("all+", "all*") and value_type != "flag":
        names.wrong(
            reference.place, f"[{reference.index}] joins flags; {symbol.name} is {TYPE_NAMES[value_type]}", "a flag"
        )
    return value_type


def rule_of(parameter: tree.ParameterOf, symbol: Symbol, names: Names) -> Rule | None:
    """Return the rule of a parameter.  One that the kind does not have is reported, and is None."""
    rules = KINDS.get(symbol.kind, PORT_PARAMETERS.get(symbol.kind, {}))
    rule = rules.get(parameter.parameter)
    if rule is None:
        what = f"{with_article(symbol.kind)} has no parameter {parameter.parameter}"
        names.wrong(parameter.place, what, listed(list(rules)) if rules else "an object with parameters")
    return rule


def _parameter(parameter: tree.ParameterOf, names: Names, context: Context) -> Type | None:
    symbol = names.object(parameter.subject)
    rule = rule_of(parameter, symbol, names) if symbol is not None else None
    if symbol is None or rule is None:
        return None
    indexed(parameter.subject, symbol, names, context)
    if rule.access not in ("RO", "RW"):
        what = f"{rule.name} of {with_article(symbol.kind)} cannot be read by a program"
        names.wrong(parameter.place, what, "a parameter with the access RO or RW")
        return None
    return "integer" if rule.holds[0].partition("/")[0] == "integer" else "real"


def _unary(unary: tree.Unary, names: Names, context: Context) -> Type | None:
    if unary.operator == "!":
        need(unary.operand, "flag", names, context)
        return "flag"
    operand_type = type_of(unary.operand, names, context)
    if operand_type is not None and operand_type not in NUMERIC:
        names.wrong(unary.place, f"{unary.operator} is in front of {TYPE_NAMES[operand_type]}", "a number")
    return operand_type if operand_type in NUMERIC else None


def _binary(binary: tree.Binary, names: Names, context: Context) -> Type | None:
    left = type_of(binary.left, names, context)
    right = type_of(binary.right, names, context)
    if binary.operator in _COMPARISONS:
        _compared(binary, left, right, names)
        return "flag"
    if left is None or right is None:
        return left or right
    if left == right == "flag" and binary.operator in ("+", "*"):
        return "flag"
    for side, side_type in ((binary.left, left), (binary.right, right)):
        if side_type not in NUMERIC:
            hint = "Comparisons bind looser than + and *: put them in parentheses." if side_type == "flag" else ""
            names.wrong(
                side.place, f"{binary.operator} joins {TYPE_NAMES[left]} and {TYPE_NAMES[right]}", "numbers", hint
            )
            return None
    result: Type = "real" if "real" in (left, right) else "integer"
    if binary.operator in ("/", "%") and constant(binary.right) == 0:
        number = "02..FFF3" if result == "real" else "02..FFF2"
        names.note(binary.place, "this divides by 0", f"Where it is computed, the PAM stops with the fault {number}.")
    return result


def _compared(binary: tree.Binary, left: Type | None, right: Type | None, names: Names) -> None:
    if left is None or right is None or (left in NUMERIC and right in NUMERIC):
        return
    if binary.operator in ("=", "<>"):
        if left == right == "flag":
            return
        if (left == "flag" and is_bit(binary.right)) or (right == "flag" and is_bit(binary.left)):
            return
    what = f"{binary.operator} compares {TYPE_NAMES[left]} with {TYPE_NAMES[right]}"
    hint = "Comparisons bind looser than + and *: put them in parentheses." if "flag" in (left, right) else ""
    names.wrong(binary.place, what, "numbers", hint)


def _inquiry(inquiry: tree.Inquiry, names: Names, context: Context) -> Type | None:
    subject = inquiry.subject
    if inquiry.function in MATHEMATICS:
        return _mathematics(inquiry, names, context)
    if not isinstance(subject, tree.Reference):
        hint = f"Write {subject.operator}(object ? {inquiry.function})." if isinstance(subject, tree.Unary) else ""
        names.wrong(inquiry.place, f"{inquiry.function} is asked of an expression", "an object", hint)
        return None
    if subject.name in context.formals:
        names.wrong(subject.place, f"{subject.name} is a parameter with a value", "an object")
        return None
    symbol = names.object(subject)
    if symbol is None:
        return None
    indexed(subject, symbol, names, context)
    forms = INQUIRIES.get(symbol.kind, {}).get(inquiry.function)
    if forms is None:
        _unknown_inquiry(inquiry, symbol, names)
        return None
    if inquiry.function in _ON_THE_RING.get(symbol.kind, ()):
        _takes_time(inquiry.place, names, context)
    return fitting(inquiry.function, forms, inquiry.arguments, inquiry, names, context)


_ON_THE_RING: Final[Mapping[str, Sequence[str]]] = {
    "ENCODER": ("position", "speed", "value"),
    "DC_MOTOR": ("position",),
}
"""Inquiries that the node answers, several cycles later."""


def _takes_time(place: tree.Place, names: Names, context: Context) -> None:
    """Say that an action does not wait for an answer (manual line 2113)."""
    if context.where == "an action":
        hint = "It has the last value, with 07..E021, unless a SAMPLER reads the object."
        names.note(place, "an action does not wait for an inquiry over the ring", hint)


def _unknown_inquiry(inquiry: tree.Inquiry, symbol: Symbol, names: Names) -> None:
    known = sorted(INQUIRIES.get(symbol.kind, {}))
    what = f"{with_article(symbol.kind)} does not know the inquiry {inquiry.function}"
    is_order = inquiry.function in EXECUTIVE.get(symbol.kind, {})
    hint = f"{inquiry.function} is an order: write {symbol.name} <- {inquiry.function}." if is_order else ""
    names.wrong(inquiry.place, what, listed(known) if known else "an object that answers inquiries", hint)


def _mathematics(inquiry: tree.Inquiry, names: Names, context: Context) -> Type | None:
    if inquiry.arguments:
        names.wrong(inquiry.place, f"{inquiry.function} takes no arguments", f"number ? {inquiry.function}")
    argument_type = type_of(inquiry.subject, names, context)
    if argument_type is not None and argument_type not in NUMERIC:
        names.wrong(inquiry.place, f"{inquiry.function} is asked of {TYPE_NAMES[argument_type]}", "a number")
    return argument_type if inquiry.function == "abs" else "real"


def fitting(
    name: str,
    forms: tuple[Function, ...],
    arguments: tuple[tree.Expression, ...],
    at: tree.Inquiry | tree.Expression,
    names: Names,
    context: Context,
) -> Type | None:
    """Return the answer of the form that fits the number of arguments.  Wrong arguments are reported."""
    form = next((form for form in forms if form.fewest <= len(arguments) <= len(form.arguments)), None)
    if form is None:
        counts = sorted({count for form in forms for count in range(form.fewest, len(form.arguments) + 1)})
        names.wrong(
            at.place,
            f"{name} has {counted(len(arguments), 'argument')}",
            f"{listed([str(count) for count in counts])} of them",
        )
        return forms[0].answer
    for argument, wanted in zip(arguments, form.arguments, strict=False):
        check_argument(argument, wanted.rstrip("?"), names, context)
    return form.answer


def check_argument(argument: tree.Expression, wanted: str, names: Names, context: Context) -> None:
    """Report an argument that is not what a function takes."""
    if wanted[0] == "(":
        words = wanted[1:-1].split("|")
        if not (isinstance(argument, tree.Word) and argument.name in words):
            names.wrong(argument.place, "the argument is wrong", listed(words))
    elif wanted[0] == "<":
        symbol = names.object(argument) if isinstance(argument, tree.Reference) else None
        if not isinstance(argument, tree.Reference) or (symbol is not None and symbol.kind != wanted[1:-1]):
            names.wrong(argument.place, "the argument is wrong", with_article(wanted[1:-1]))
        elif symbol is not None:
            indexed(argument, symbol, names, context, is_target=True)
    elif wanted == "text":
        need(argument, "text", names, context)
    else:
        need(argument, "integer" if wanted == "integer" else "real", names, context)
