"""Expressions."""

from dataclasses import dataclass, field
from enum import Enum

from fieldrig_devices.iec.tree.nodes import Node


class LiteralKind(Enum):
    BOOL = "BOOL"
    INTEGER = "integer"
    REAL = "real number"
    STRING = "STRING"
    WSTRING = "WSTRING"
    TIME = "TIME"
    DATE = "DATE"
    TOD = "TIME_OF_DAY"
    DT = "DATE_AND_TIME"
    LTIME = "LTIME"
    LDATE = "LDATE"
    LTOD = "LTIME_OF_DAY"
    LDT = "LDATE_AND_TIME"


@dataclass(slots=True)
class Literal(Node):
    """A constant.  `value` is as at run time (`types.Elementary` has the units of times); a string has no quotes."""

    kind: LiteralKind
    value: bool | int | float | str
    text: str = field(default="", compare=False)
    """The text as it was written; the printer uses it where it is not empty."""
    type_name: str = ""
    """The type in front of the constant, `INT#5`; empty without."""


@dataclass(slots=True)
class Name(Node):
    text: str


@dataclass(slots=True)
class Member(Node):
    """`of.name`: a component, a variable of an instance, a parameter of an object, a value of an enumeration."""

    of: "Expression"
    name: str


@dataclass(slots=True)
class BitOf(Node):
    """`of.5` or `of.%X5`: a bit of an integer or bit string; `of.%B1`, `of.%W0`: a byte or word of it."""

    of: "Expression"
    number: int
    size: str = ""
    """B, W, D or L; empty for a bit."""


@dataclass(slots=True)
class Index(Node):
    of: "Expression"
    indices: "tuple[Expression, ...]"


@dataclass(slots=True)
class Dereference(Node):
    of: "Expression"


@dataclass(slots=True)
class Direct(Node):
    """A directly represented variable, such as %IX5.0, %QB3, %MD48 (PD-363)."""

    area: str
    """I, Q or M."""
    size: str
    """X, B, W or D; empty as in %Q75, which is a bit."""
    numbers: tuple[int, ...]


@dataclass(slots=True)
class Argument(Node):
    """An argument: `value`, `name := value`, `name => value` or `NOT name => value`."""

    value: "Expression | None"
    """None for an output that is not assigned: `Q => `."""
    name: str = ""
    is_output: bool = False
    is_negated: bool = False


@dataclass(slots=True)
class Call(Node):
    """A call of a function, or of an instance, program or action as a statement."""

    called: "Expression"
    arguments: tuple[Argument, ...]


@dataclass(slots=True)
class Unary(Node):
    """`operator` is "-", "+" or "NOT"; "POINTER TO" in front of the type that `__NEW` makes pointers to."""

    operator: str
    operand: "Expression"


@dataclass(slots=True)
class Binary(Node):
    """`operator` is one of + - * / ** MOD AND OR XOR AND_THEN OR_ELSE = <> < > <= >= ("&" is AND)."""

    operator: str
    left: "Expression"
    right: "Expression"


@dataclass(slots=True)
class Assigned(Node):
    """`target := value` within an expression, whose value is that of the target then."""

    target: "Expression"
    value: "Expression"


Expression = Literal | Name | Member | BitOf | Index | Dereference | Direct | Call | Unary | Binary | Assigned


@dataclass(slots=True)
class Range(Node):
    low: Expression
    high: Expression
