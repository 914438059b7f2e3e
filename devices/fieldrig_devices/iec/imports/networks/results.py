"""The type of an operation or of a standard function in a drawing, by the rules that the checker has for texts.

The operands are values of known types and literals, which take the type of the other operands (IEC 61131-3, 6.4.2).
"""

from collections.abc import Sequence

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import constants, operators, standard, untyped
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.expressions import LITERAL_TYPES, Expressions
from fieldrig_devices.iec.check.project import Project
from fieldrig_devices.iec.check.untyped import Untyped
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library import conversions, fixed, intrinsics
from fieldrig_devices.iec.library.arguments import fits
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.program import Cell, Constant, Expression, Load, Operator, Space, Variable
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tree import LiteralKind, Section
from fieldrig_devices.iec.types import StringType, Type

_SIGNS = {operator.value: operator for operator in Operator}
_SOMEWHERE = tree.Name("", position=tree.NOWHERE)


class Results:
    """Typed values of no program, and what becomes of them; what is wrong with them is said elsewhere."""

    def __init__(self, dialect: Dialect) -> None:
        self._expressions = Expressions(Context(Project(StandaloneHost(VirtualClock()), dialect, Limits()), None, ""))
        self._context = self._expressions.context

    def of_type(self, kind: Type) -> Expression:
        """Return a value of the type that is not constant."""
        return Load(Cell(Variable("", kind, Space.GLOBAL, Section.GLOBAL), kind))

    def of_literal(self, node: tree.Literal) -> Expression:
        """Return the value of a literal without a type in front."""
        match node.kind, node.value:
            case LiteralKind.INTEGER, int() as number:
                return untyped.integer(number, is_pattern="#" in node.text)
            case LiteralKind.REAL, float() as number:
                return untyped.real(number)
            case (LiteralKind.STRING | LiteralKind.WSTRING) as kind, str() as text:
                return Constant(text, StringType(max(len(text), 1), kind is LiteralKind.WSTRING))
        is_time = node.kind is LiteralKind.TIME
        return self.of_type(self._context.project.dialect.time if is_time else LITERAL_TYPES[node.kind])

    def unary(self, sign: str, operand: Expression) -> Expression | None:
        """Return a value with NOT or a minus sign in front."""
        if sign == "+":
            return operand
        return operators.unary(self._context, Operator.NOT if sign == "NOT" else Operator.NEG, operand, _SOMEWHERE)

    def binary(self, sign: str, left: Expression, right: Expression, wanted: Type | None = None) -> Expression | None:
        """Return the operation with the sign of the language, such as `+` or MOD; None if there is none."""
        if sign == "**":
            return self.call("EXPT", [left, right], wanted)
        return operators.binary(self._context, _SIGNS[sign], left, right, _SOMEWHERE)

    def call(self, name: str, values: Sequence[Expression], wanted: Type | None = None) -> Expression | None:
        """Return the result of a standard function; None if it does not take such arguments."""
        key = name.upper()
        if key == "TRUNC" and wanted is None:
            wanted = Elementary.DINT
        if not intrinsics.is_standard(key):
            return None
        return standard.of_values(self._expressions, key, values, _SOMEWHERE, wanted)


def result_by_name(name: str) -> Type | None:
    """Return the type that the name of a standard function says: INT for STRING_TO_INT, TO_INT and LEN."""
    key = name.upper()
    types = conversions.pair(key)
    if types is not None:
        return types[1]
    if key in fixed.FIXED:
        return fixed.FIXED[key].result
    return conversions.named(key.removeprefix("ANY_").removeprefix("TO_")) if "TO_" in key else None


def type_of(value: Expression, wanted: Type | None = None) -> Type:
    """Return the type in which a value is kept: a literal has the one that is wanted, if it fits."""
    if type(value) is not Untyped:
        return value.type
    number = value.value
    assert not isinstance(number, str)
    return wanted if isinstance(wanted, Elementary) and fits(number, wanted) else value.type


def whole_type_of(value: Expression) -> Type | None:
    """Return the type with 32 bits that arithmetic has given a value of a smaller type; None for other values."""
    whole = constants.whole(value)
    return whole.type if whole is not value else None
