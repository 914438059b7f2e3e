"""Expressions as Python: operators, conversions and standard functions.

An expression has no calls of functions any more (`hoisting`), so it has no side effects.  What can raise, such as a
division, becomes a line of its own; the text that is left never does, and may be skipped by Python's `and` and `or`.
"""

from collections.abc import Sequence
from typing import Final

from fieldrig_devices.iec.elementary import SHORT_TIMES, Elementary, Family
from fieldrig_devices.iec.layout import storage
from fieldrig_devices.iec.library import conversions, intrinsics
from fieldrig_devices.iec.library.overload import expand
from fieldrig_devices.iec.lower import texts
from fieldrig_devices.iec.lower.conditions import is_joint
from fieldrig_devices.iec.lower.emitter import Emitter
from fieldrig_devices.iec.lower.places import Places
from fieldrig_devices.iec.lower.values import Stored, Value, constant, of_type
from fieldrig_devices.iec.program import (
    COMPARISONS,
    AddressOf,
    Allocate,
    Binary,
    Constant,
    Convert,
    Expression,
    Intrinsic,
    Load,
    Operator,
    Unary,
)
from fieldrig_devices.iec.types import EnumType, SubrangeType

COMPARE: Final = {
    Operator.EQ: "==",
    Operator.NE: "!=",
    Operator.LT: "<",
    Operator.LE: "<=",
    Operator.GT: ">",
    Operator.GE: ">=",
}
BITS: Final = {Operator.AND: "&", Operator.OR: "|", Operator.XOR: "^"}
BOOLEANS: Final = {Operator.AND: "and", Operator.OR: "or", Operator.AND_THEN: "and", Operator.OR_ELSE: "or"}
ARITHMETIC: Final = {Operator.ADD: "+", Operator.SUB: "-", Operator.MUL: "*"}


class Expressions:
    def __init__(self, places: Places) -> None:
        self._places = places
        places.values = self
        self._conditions: list[str] | None = None
        """The conditions of the decision that is being lowered; None if they have no marks."""

    def decision(self, expression: Expression, emitter: Emitter, conditions: list[str]) -> Value:
        """Return the value of a decision as `raw` does, and add the variables with the values of its conditions.

        A condition that is not evaluated has the value 0.
        """
        self._conditions = conditions
        value = self.raw(expression, emitter)
        self._conditions = None
        return value

    def value(self, expression: Expression, emitter: Emitter) -> Value:
        """Add the lines that compute an expression, and return its value in the range of its type."""
        conditions = self._conditions
        if conditions is None or is_joint(expression):
            return emitter.cut(self.raw(expression, emitter))
        self._conditions = None  # what is inside of a condition is none
        value = emitter.atom(emitter.cut(self.raw(expression, emitter)))
        self._conditions = conditions
        conditions.append(value.text)
        return value

    def raw(self, expression: Expression, emitter: Emitter) -> Value:
        """Return the value, which may have to be cut to its type."""
        match expression:
            case Constant(value):
                return constant(value, self._stored(expression))
            case Load(place):
                return self._places.load(place, emitter)
            case Binary():
                return self._binary(expression, emitter)
            case Unary():
                return self._unary(expression, emitter)
            case Convert():
                return self._convert(expression, emitter)
            case Intrinsic():
                return self._intrinsic(expression, emitter)
            case AddressOf(place):
                return self._places.reference(place, emitter)
            case Allocate(of, count):
                emitter.charge(emitter.costs.copy_ns * of.size)
                text = f"allocate({self._places.form(of)}, {self.value(count, emitter).text})"
                return of_type(emitter.new(text), Elementary.DWORD)
        raise AssertionError(f"{expression} is not hoisted")

    @staticmethod
    def _stored(expression: Expression) -> Stored:
        kind = storage(expression.type)
        assert kind is not None, expression
        return kind

    # ---- operators

    def _unary(self, expression: Unary, emitter: Emitter) -> Value:
        kind = self._stored(expression)
        assert isinstance(kind, Elementary)
        emitter.charge_for(kind)
        if expression.operator is Operator.NEG:
            value = emitter.limited(self.raw(expression.operand, emitter))
            return Value(f"(-{value.text})", kind, -value.high, -value.low)
        value = emitter.short(self.value(expression.operand, emitter))
        if kind is Elementary.BOOL:
            return Value(f"(not {value.text})", kind)
        if kind.family is Family.SIGNED:
            return Value(f"(~{value.text})", kind, ~value.high, ~value.low)
        return of_type(f"({value.text} ^ {kind.high})", kind)

    def _binary(self, expression: Binary, emitter: Emitter) -> Value:
        operator = expression.operator
        if operator in (Operator.AND_THEN, Operator.OR_ELSE):
            return self._short_circuit(expression, emitter)
        if operator in ARITHMETIC:
            return self._arithmetic(expression, emitter)
        left = emitter.short(self.value(expression.left, emitter))
        right = emitter.short(self.value(expression.right, emitter))
        if operator in COMPARISONS:
            emitter.charge_for(left.type)
            return Value(f"({left.text} {COMPARE[operator]} {right.text})", Elementary.BOOL)
        if operator in (Operator.DIV, Operator.MOD):
            return self._divide(expression, left, right, emitter)
        emitter.charge(emitter.costs.operation_ns)
        if expression.type is Elementary.BOOL:
            if operator is Operator.XOR:
                return Value(f"({left.text} != {right.text})", Elementary.BOOL)
            return Value(f"({left.text} {BOOLEANS[operator]} {right.text})", Elementary.BOOL)
        return self._bits(operator, left, right, self._stored(expression))

    def _bits(self, operator: Operator, left: Value, right: Value, kind: Stored) -> Value:
        value = of_type(f"({left.text} {BITS[operator]} {right.text})", kind)
        if operator is Operator.AND and (left.low >= 0 or right.low >= 0):
            highs = [side.high for side in (left, right) if side.low >= 0]
            value.low, value.high = 0, min(highs)
        return value

    def _short_circuit(self, expression: Binary, emitter: Emitter) -> Value:
        """AND_THEN and OR_ELSE: the right side runs only if the left one does not decide."""
        left = self.value(expression.left, emitter)
        emitter.charge(emitter.costs.jump_ns)
        part = len(emitter.lines)
        name = emitter.new(left.text)
        emitter.add(f"if {name}:" if expression.operator is Operator.AND_THEN else f"if not {name}:")
        emitter.deeper()
        before = len(emitter.lines)
        known = len(self._conditions or ())
        right = self.value(expression.right, emitter)
        for condition in (self._conditions or ())[known:]:
            if condition.isidentifier() and len(emitter.lines) > before:
                emitter.lines.insert(part, emitter.outer(f"{condition} = 0"))
                before += 1
        if len(emitter.lines) == before:  # nothing in it can raise
            emitter.back()
            del emitter.lines[part:]
            return Value(f"({left.text} {BOOLEANS[expression.operator]} {right.text})", Elementary.BOOL)
        emitter.add(f"{name} = {right.text}")
        emitter.back()
        return Value(name, Elementary.BOOL)

    def _arithmetic(self, expression: Binary, emitter: Emitter) -> Value:
        operator, kind = expression.operator, self._stored(expression)
        assert isinstance(kind, Elementary)
        if kind.is_real:
            left, right = self.value(expression.left, emitter), self.value(expression.right, emitter)
            emitter.charge(emitter.costs.real_ns)
            left, right = emitter.short(left), emitter.short(right)
            return emitter.single(_bracketed(left, ARITHMETIC[operator], right, kind), kind)
        if (product := self._time_by_real(expression, emitter)) is not None:
            return product
        left, right = self._operand(expression.left, kind, emitter), self._operand(expression.right, kind, emitter)
        emitter.charge(emitter.costs.multiply_ns if operator is Operator.MUL else emitter.costs.operation_ns)
        text = f"({left.text} {ARITHMETIC[operator]} {right.text})"
        if operator is Operator.ADD:
            return Value(text, kind, left.low + right.low, left.high + right.high)
        if operator is Operator.SUB:
            return Value(text, kind, left.low - right.high, left.high - right.low)
        ends = [a * b for a in (left.low, left.high) for b in (right.low, right.high)]
        return Value(text, kind, min(ends), max(ends))

    def _operand(self, expression: Expression, kind: Elementary, emitter: Emitter) -> Value:
        """Return an operand, which need not be cut if it has the type of the result."""
        raw = self.raw(expression, emitter)
        return emitter.limited(raw) if raw.type is kind else emitter.short(emitter.cut(raw))

    def _time_by_real(self, expression: Binary, emitter: Emitter) -> Value | None:
        """TIME * REAL is truncated; None for other products."""
        sides = (expression.left, expression.right)
        if not any(isinstance(side.type, Elementary) and side.type.is_real for side in sides):
            return None
        left, right = (self.value(side, emitter) for side in sides)
        emitter.charge(emitter.costs.real_ns)
        return of_type(f"(TRUNCATE({left.text} * {right.text}) & {2**32 - 1})", Elementary.TIME)

    def _divide(self, expression: Binary, left: Value, right: Value, emitter: Emitter) -> Value:
        kind = self._stored(expression)
        assert isinstance(kind, Elementary)
        if kind.is_real:
            emitter.charge(emitter.costs.real_ns)
            text = _bracketed(left, "/", right, kind)
            return emitter.single(text, kind) if kind is Elementary.REAL else Value(emitter.new(text), kind)
        emitter.charge(emitter.costs.divide_ns)
        if isinstance(right.type, Elementary) and right.type.is_real:  # TIME / REAL
            return of_type(emitter.new(f"TRUNCATE({left.text} / {right.text}) & {2**32 - 1}"), kind)
        sign = "//" if expression.operator is Operator.DIV else "%"
        if left.low >= 0 and right.low >= 0:
            return _quotient(self._line(f"{left.text} {sign} {right.text}", right, emitter), kind, sign, left, right)
        left = emitter.atom(left)
        if right.low > 0:
            text = f"{left.text} {sign} {right.text} if {left.text} >= 0 else -(-{left.text} {sign} {right.text})"
            return _quotient(emitter.new(text), kind, sign, left, right)
        right = emitter.atom(right)
        if sign == "//":
            is_same = f"({left.text} >= 0) == ({right.text} > 0)"
            text = f"{left.text} // {right.text} if {is_same} else -(-{left.text} // {right.text})"
        else:  # the remainder has the sign of the dividend
            size = f"({right.text} if {right.text} >= 0 else -{right.text})"
            text = f"{left.text} % {size} if {left.text} >= 0 else -(-{left.text} % {size})"
        return _quotient(emitter.new(text), kind, sign, left, right)

    @staticmethod
    def _line(text: str, right: Value, emitter: Emitter) -> str:
        """Return a division as part of a larger expression if it cannot fail, and as a line of its own otherwise."""
        return f"({text})" if right.low > 0 else emitter.new(text)

    # ---- conversions and functions

    def _convert(self, expression: Convert, emitter: Emitter) -> Value:
        source, target = self._stored(expression.operand), self._stored(expression)
        raw = self.raw(expression.operand, emitter)
        if isinstance(expression.type, SubrangeType | EnumType):
            return self._checked(self._converted(raw, source, target, emitter), expression.type, emitter)
        return self._converted(raw, source, target, emitter)

    def _checked(self, value: Value, kind: SubrangeType | EnumType, emitter: Emitter) -> Value:
        """Return a value in the range of a subrange or an enumeration; another one is a fault (PD-359)."""
        value = emitter.cut(value)
        ranges = kind.ranges
        low, high = ranges[0][0], ranges[-1][1]
        if len(ranges) == 1 and low <= value.low and value.high <= high:
            return value
        emitter.charge(emitter.costs.operation_ns * len(ranges))
        value = emitter.atom(value)
        allowed = " or ".join(f"{first} <= {value.text} <= {last}" for first, last in ranges)
        emitter.add(f"if not ({allowed}):")
        emitter.add(f"    outside_range({value.text}, {', '.join(f'{first}, {last}' for first, last in ranges)})")
        return Value(value.text, value.type, low, high)

    def _converted(self, raw: Value, source: Stored, target: Stored, emitter: Emitter) -> Value:
        if source is target:
            return raw
        if _is_number(source) and _is_number(target):
            assert isinstance(source, Elementary)
            assert isinstance(target, Elementary)
            if target.bits > source.bits or raw.low < -(2**62) or raw.high > 2**62:
                raw = emitter.cut(raw)
            return Value(raw.text, target, raw.low, raw.high)  # cut to the target where it is used
        value = emitter.short(emitter.cut(raw))
        emitter.charge(conversions.cost_of(source, target))
        if isinstance(source, Elementary) and isinstance(target, Elementary) and target.is_real:
            if source is Elementary.REAL:
                return Value(value.text, target)
            if source is Elementary.LREAL:
                return emitter.single(value.text, target)
            if source.bits <= 32:
                is_exact = target is Elementary.LREAL or (value.low >= -(2**24) and value.high <= 2**24)
                text = f"({value.text} + 0.0)"
                return Value(text, target) if is_exact else emitter.single(text, target)
        return of_type(expand(conversions.python_of(source, target), [value.text]), target)

    def _chosen(self, expression: Intrinsic, emitter: Emitter) -> Value:
        """Return what SEL chooses; what it does not choose is not computed if it can fail, such as outside of an array.

        Each argument is lowered once, as its arguments may be calls of SEL too.
        """
        condition, first, second = expression.arguments
        chooser = self.value(condition, emitter)
        part = len(emitter.lines)
        name = emitter.new("0")
        emitter.add(f"if {chooser.text}:")
        before = len(emitter.lines)
        values = []
        for one in (second, first):
            emitter.deeper()
            values.append(self.value(one, emitter))
            emitter.add(f"{name} = {values[-1].text}")
            emitter.back()
            emitter.add("else:")
        emitter.lines.pop()
        if len(emitter.lines) == before + 3:  # neither can fail
            del emitter.lines[part:]
            return self._applied(expression, [emitter.short(one) for one in (chooser, *reversed(values))], emitter)
        emitter.charge(intrinsics.implementation(expression.name).cost_ns)
        return of_type(name, self._stored(expression))

    def _intrinsic(self, expression: Intrinsic, emitter: Emitter) -> Value:
        if expression.name.partition(".")[0] == "SEL":
            return self._chosen(expression, emitter)
        arguments = [emitter.short(self.value(argument, emitter)) for argument in expression.arguments]
        return self._applied(expression, arguments, emitter)

    def _applied(self, expression: Intrinsic, arguments: Sequence[Value], emitter: Emitter) -> Value:
        """Return the value of a standard function of these values, whose texts are short."""
        implementation = intrinsics.implementation(expression.name)
        emitter.charge(implementation.cost_ns)
        own = texts.OWN.get(expression.name)
        if own is not None and (value := own(arguments, emitter)) is not None:
            return value
        kind = self._stored(expression)
        text = implementation.expand([argument.text for argument in arguments])
        if kind is Elementary.REAL and text.startswith("SINGLE(") and text.endswith(")"):
            return emitter.single(text[len("SINGLE") :], kind)
        return emitter.short(of_type(text, kind))


def _is_number(kind: Stored) -> bool:
    """True for the types that become one another by cutting bits alone."""
    return isinstance(kind, Elementary) and (kind.is_integer or kind in (*SHORT_TIMES, Elementary.DT))


def _bracketed(left: Value, sign: str, right: Value, kind: Elementary) -> str:
    text = f"{left.text} {sign} {right.text}"
    return text if kind is Elementary.REAL or sign == "/" else f"({text})"


def _quotient(text: str, kind: Elementary, sign: str, left: Value, right: Value) -> Value:
    """Return a quotient or remainder with its range; only the lowest number by -1 has to be cut."""
    if sign == "%":
        most = max(abs(right.low), abs(right.high)) - 1
        return Value(text, kind, 0 if left.low >= 0 else -most, most)
    most = max(abs(left.low), abs(left.high)) // max(right.low, 1)
    return Value(text, kind, 0 if left.low >= 0 and right.low >= 0 else -most, most)
