"""Expressions as Python: variables are cells of the list M, and objects are asked by functions (`uses`)."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Final

from fieldrig_devices.pam.language import tree
from fieldrig_devices.pam.language.functions import INQUIRIES, MATHEMATICS, VALUES, Type
from fieldrig_devices.pam.language.objects import KINDS, PORT_PARAMETERS
from fieldrig_devices.pam.language.words import PREDECLARED
from fieldrig_devices.pam.runtime.layout import Layout
from fieldrig_devices.pam.runtime.lower.formulas import Formula, Formulas
from fieldrig_devices.pam.runtime.lower.operands import HIGH, LOW, Emitter, Operand, OperandOf
from fieldrig_devices.pam.runtime.lower.uses import PENDING, Argument, Fixed, ItemOf, Use, Uses, Verb
from fieldrig_devices.pam.runtime.walk import nodes

COMPARE: Final = {"=": "==", "<>": "!=", "<": "<", "<=": "<=", ">": ">", ">=": ">="}
WORDS: Final = ("error_code", "status")
"""Inquiries that answer 32 bits without a sign."""
_ASKED: Final = {"ENCODER": "value", "AXIS": "position"}
"""The inquiries that the names of these objects stand for; that of an axis does so behind `PamDisplay <-` only."""
LARGEST_REAL: Final = 1.7976931348623157e308


@dataclass(frozen=True, slots=True)
class Formal:
    """A formal parameter of a routine: its cell behind `frame`, and the type of its argument (G-26)."""

    slot: int
    type: Type


@dataclass(slots=True)
class Surroundings:
    """The surroundings of an expression."""

    formals: Mapping[str, Formal] = field(default_factory=dict)
    asks: Verb = Verb.NOW
    """How an inquiry is made whose answer may be pending."""
    answers: dict[int, str] = field(default_factory=dict)
    """The texts of inquiries of the present statement that a sequence has made before, by the identity of the node."""
    items: str = ""
    """The object, task or equation whose present item [i] is."""


class Expressions:
    def __init__(self, layout: Layout, uses: Uses, formulas: Formulas) -> None:
        self.layout, self.uses, self.formulas = layout, uses, formulas

    def kind(self, name: str) -> str:
        return PREDECLARED.get(name) or self.layout.kinds[name]

    # ---- operands

    def operand(self, expression: tree.Expression, emitter: Emitter, at: Surroundings) -> Operand:
        """Add the lines that compute an expression, and return its value."""
        match expression:
            case tree.Number(value=value):
                return _number(value)
            case tree.Text(value=text):
                raise AssertionError(f"the text {text!r} is no operand")
            case tree.Word(name="PI"):
                return Operand("3.141592653589793", "real")  # manual line 6691
            case tree.Word():
                return Operand("timed_out()", "flag")
            case tree.Reference():
                return self._value(expression, at)
            case tree.ParameterOf(subject=subject, parameter=parameter):
                return self._parameter(subject, parameter)
            case tree.Unary(operator="-", operand=tree.Number(value=value)) if value == HIGH + 1:
                return _number(-value)  # without its sign, the lowest integer is a mask of 32 bits
            case tree.Unary():
                return self._unary(expression, emitter, at)
            case tree.Binary():
                return self._binary(expression, emitter, at)
            case tree.Inquiry():
                return self._inquiry(expression, emitter, at)
            case tree.Reduction():
                return self._reduction(expression, at)

    def _value(self, reference: tree.Reference, at: Surroundings) -> Operand:
        formal = at.formals.get(reference.name)
        if formal is not None:
            return Operand(cell("frame", formal.slot), formal.type)
        cells = self.layout.cells.get(reference.name)
        if cells is not None:
            if reference.index in ("all+", "all*"):
                return self._joined(reference, at)
            return Operand(cell("base" if reference.index == "i" else "", cells.first), cells.type)
        kind = self.kind(reference.name)
        if kind in _ASKED:
            return self._asked(reference, reference, _ASKED[kind], "real", [], at)
        if reference.index in ("all+", "all*"):
            return self._joined(reference, at)
        called = self.uses.name(Use(Verb.VALUE, reference.name, reference.index))
        return Operand(f"{called}({base_of(reference)})", VALUES[kind])

    def _joined(self, reference: tree.Reference, at: Surroundings) -> Operand:
        """An object with [all+] or [all*]: the inquiry or value over all items."""
        assert reference.index in ("all+", "all*")
        each = tree.Reference(reference.place, reference.name, "i")
        return self._reduction(tree.Reduction(reference.place, each, reference.index), at)

    def _parameter(self, subject: tree.Reference, parameter: str) -> Operand:
        kind = self.kind(subject.name)
        rule = KINDS.get(kind, PORT_PARAMETERS.get(kind, {}))[parameter]
        called = self.uses.name(Use(Verb.GET, subject.name, subject.index, parameter))
        return Operand(
            f"{called}({base_of(subject)})", "integer" if rule.holds[0].partition("/")[0] == "integer" else "real"
        )

    # ---- operators

    def _unary(self, unary: tree.Unary, emitter: Emitter, at: Surroundings) -> Operand:
        value = emitter.short(self.operand(unary.operand, emitter, at))
        if unary.operator == "!":
            return Operand(f"(not {emitter.flag(value).text})", "flag")
        value = emitter.number(value)
        if unary.operator == "+":
            return value
        if value.type == "real":
            return Operand(f"(-{value.text})", "real", is_finite=value.is_finite)
        return emitter.in_range(Operand(f"(-{value.text})", "integer", -value.high, -value.low))

    def _binary(self, binary: tree.Binary, emitter: Emitter, at: Surroundings) -> Operand:
        left = emitter.short(self.operand(binary.left, emitter, at))
        right = emitter.short(self.operand(binary.right, emitter, at))
        operator = binary.operator
        if operator in COMPARE:
            left, right = emitter.checked(left), emitter.checked(right)
            return Operand(f"({left.text} {COMPARE[operator]} {right.text})", "flag")
        if left.type == right.type == "flag" and operator in ("+", "*"):
            return Operand(f"({left.text} {'or' if operator == '+' else 'and'} {right.text})", "flag")
        left, right = emitter.number(left), emitter.number(right)
        if operator == "^":
            return Operand(emitter.new(f"power({emitter.finite(left).text}, {emitter.finite(right).text})"), "real")
        if "real" in (left.type, right.type):
            return _real(operator, left, right, emitter)
        return _integer(operator, left, right, emitter)

    # ---- inquiries

    def _inquiry(self, inquiry: tree.Inquiry, emitter: Emitter, at: Surroundings) -> Operand:
        subject, function = inquiry.subject, inquiry.function
        if function in MATHEMATICS:
            return self._mathematics(function, emitter.number(self.operand(subject, emitter, at)), emitter)
        assert isinstance(subject, tree.Reference)
        forms = INQUIRIES[self.kind(subject.name)][function]
        form = next(form for form in forms if form.fewest <= len(inquiry.arguments) <= len(form.arguments))
        assert form.answer is not None
        if subject.index in ("all+", "all*"):
            each = tree.Inquiry(
                inquiry.place, tree.Reference(subject.place, subject.name, "i"), function, inquiry.arguments
            )
            return self._reduction(tree.Reduction(inquiry.place, each, subject.index), at)
        values = [emitter.checked(self.operand(argument, emitter, at)).text for argument in inquiry.arguments]
        return self._asked(inquiry, subject, function, form.answer, values, at)

    def _asked(
        self, node: tree.Node, subject: tree.Reference, function: str, answer: Type, values: list[str], at: Surroundings
    ) -> Operand:
        if id(node) in at.answers:
            return Operand(at.answers[id(node)], answer)
        verb = at.asks if (self.kind(subject.name), function) in PENDING else Verb.ASK
        called = self.uses.name(Use(verb, subject.name, subject.index, function, (None,) * len(values)))
        text = f"{called}({', '.join([*filter(None, [base_of(subject)]), *values])})"
        return Operand(f"signed({text})" if answer == "integer" and function in WORDS else text, answer)

    @staticmethod
    def _mathematics(function: str, value: Operand, emitter: Emitter) -> Operand:
        value = emitter.atom(emitter.checked(value))
        if function == "abs":
            text = f"({value.text} if {value.text} >= 0 else -{value.text})"
            if value.type == "real":
                return Operand(text, "real")
            return emitter.in_range(Operand(text, "integer", 0, max(-value.low, value.high)))
        return Operand(emitter.new(f"{function}({value.text})"), "real")

    def _reduction(self, reduction: tree.Reduction, at: Surroundings) -> Operand:
        """A formula of its own for each item, joined over those that are active (PAML-246, G-46)."""
        references = [node for node in nodes(reduction.operand) if isinstance(node, tree.Reference)]
        over = next((node.name for node in references if node.index == "i"), "")
        formula = self.formula(reduction.operand, over)
        verb = Verb.ANY if reduction.index == "all+" else Verb.ALL
        return Operand(f"{self.uses.name(Use(verb, over, None, str(formula.number)))}()", "flag")

    def formula(
        self,
        expression: tree.Expression,
        items: str = "",
        wanted: Type | None = "flag",
        lower: Callable[[tree.Expression, Emitter, OperandOf], Operand] | None = None,
    ) -> Formula:
        """Return a function of the present item that computes an expression, with what it depends on.

        `lower` makes the value of the whole expression from those of its parts, and may add lines.
        """
        emitter, at = Emitter(), Surroundings(asks=Verb.POLL, items=items)
        operand_of = partial(self.operand, at=at)
        value = emitter.checked(
            operand_of(expression, emitter) if lower is None else lower(expression, emitter, operand_of)
        )
        value = value if wanted is None else emitter.as_type(value, wanted)
        return self.formulas.add(expression, [*emitter.lines, f"return {value.text}"], value.type, self)

    # ---- arguments of functions of objects

    def arguments(
        self, expressions: Sequence[tree.Expression], emitter: Emitter, at: Surroundings
    ) -> tuple[tuple[Argument, ...], list[str]]:
        """Return what the arguments of a function are, and the texts of those that are computed."""
        lowered: list[Argument] = []
        texts: list[str] = []
        for expression in expressions:
            match expression:
                case tree.Text(value=text):
                    lowered.append(Fixed(text))
                case tree.Word(name=name) if name not in ("PI", "TIMEOUT"):
                    lowered.append(Fixed(name))
                case tree.Reference(name=name, index=index) if self._is_object(name, at):
                    lowered.append(ItemOf(name, index))
                case _:
                    lowered.append(None)
                    texts.append(emitter.checked(self.operand(expression, emitter, at)).text)
        return tuple(lowered), texts

    def _is_object(self, name: str, at: Surroundings) -> bool:
        return name not in at.formals and self.kind(name) not in VALUES


def _number(value: int | float) -> Operand:
    if isinstance(value, float):
        return Operand(repr(min(value, LARGEST_REAL)), "real")
    signed = value - 2**32 if value > HIGH else value  # a mask of 32 bits
    return Operand(str(signed) if signed >= 0 else f"({signed})", "integer", signed, signed)


def _real(operator: str, left: Operand, right: Operand, emitter: Emitter) -> Operand:
    match operator:
        case "%":
            texts = emitter.finite(left).text, emitter.finite(right).text
            return Operand(emitter.new(f"remainder({texts[0]}, {texts[1]}) + 0.0"), "real")
        case "/":
            return Operand(emitter.new(f"{left.text} / {emitter.finite(right).text}"), "real", is_finite=False)
    return Operand(f"({left.text} {operator} {right.text})", "real", is_finite=False)


def _integer(operator: str, left: Operand, right: Operand, emitter: Emitter) -> Operand:
    match operator:
        case "+":
            low, high = left.low + right.low, left.high + right.high
        case "-":
            low, high = left.low - right.high, left.high - right.low
        case "*":
            ends = [a * b for a in (left.low, left.high) for b in (right.low, right.high)]
            low, high = min(ends), max(ends)
        case _:
            return _divided(operator, left, right, emitter)
    return emitter.in_range(Operand(f"({left.text} {operator} {right.text})", "integer", low, high))


def _divided(operator: str, left: Operand, right: Operand, emitter: Emitter) -> Operand:
    """Return a quotient that is truncated toward zero, or a remainder with the sign of the first operand."""
    divisor = right.constant
    sign = "//" if operator == "/" else "%"
    if divisor is None or divisor <= 0:
        called = "quotient" if operator == "/" else "remainder"
        return Operand(emitter.new(f"{called}({left.text}, {right.text})"), "integer")
    value = emitter.atom(left)
    if left.low >= 0:
        return Operand(f"({value.text} {sign} {divisor})", "integer", 0, left.high)
    text = f"({value.text} {sign} {divisor} if {value.text} >= 0 else -(-{value.text} {sign} {divisor}))"
    return Operand(text, "integer", LOW, HIGH)


def cell(start: str, number: int) -> str:
    """Return the text of a cell, counted from `base`, from `frame`, or from the first one."""
    if not start:
        return f"M[{number}]"
    return f"M[{start} + {number}]" if number else f"M[{start}]"


def base_of(reference: tree.Reference) -> str:
    return "base" if reference.index == "i" else ""
