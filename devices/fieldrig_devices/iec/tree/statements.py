"""Statements of Structured Text."""

from dataclasses import dataclass, field
from enum import Enum

from fieldrig_devices.iec.tree.expressions import Call, Expression, Range
from fieldrig_devices.iec.tree.nodes import Node, Statement


class AssignKind(Enum):
    PLAIN = ":="
    SET = "S="
    RESET = "R="
    REFER = "REF="
    ATTEMPT = "?="


@dataclass(slots=True)
class Assign(Statement):
    target: Expression
    value: Expression
    kind: AssignKind = AssignKind.PLAIN
    others: tuple[Expression, ...] = ()
    """The further targets of `target := other := value`, from left to right."""


@dataclass(slots=True)
class CallStatement(Statement):
    call: Call


@dataclass(slots=True)
class Return(Statement):
    condition: Expression | None = None
    """The condition of `RETURN (condition);`."""


@dataclass(slots=True)
class Exit(Statement):
    pass


@dataclass(slots=True)
class Continue(Statement):
    pass


@dataclass(slots=True)
class Empty(Statement):
    pass


@dataclass(slots=True)
class Label(Statement):
    """A jump target `name:`, from graphic languages and for dialects that know it in ST."""

    name: str


@dataclass(slots=True)
class Jump(Statement):
    """`JMP name;`"""

    label: str


@dataclass(slots=True)
class Branch(Node):
    condition: Expression
    body: "tuple[AnyStatement, ...]"
    remark: str = field(default="", compare=False, repr=False, kw_only=True)
    """A comment behind THEN."""


@dataclass(slots=True)
class If(Statement):
    branches: tuple[Branch, ...]
    otherwise: "tuple[AnyStatement, ...] | None" = None


@dataclass(slots=True)
class CaseBranch(Node):
    labels: tuple[Expression | Range, ...]
    body: "tuple[AnyStatement, ...]"
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    """Comments in front of the labels."""
    remark: str = field(default="", compare=False, repr=False, kw_only=True)
    """A comment behind the labels."""
    is_spaced: bool = field(default=False, compare=False, repr=False, kw_only=True)
    """True if an empty line precedes it."""


@dataclass(slots=True)
class Case(Statement):
    selector: Expression
    branches: tuple[CaseBranch, ...]
    otherwise: "tuple[AnyStatement, ...] | None" = None


@dataclass(slots=True)
class For(Statement):
    variable: Expression
    first: Expression
    last: Expression
    step: Expression | None
    body: "tuple[AnyStatement, ...]"


@dataclass(slots=True)
class While(Statement):
    condition: Expression
    body: "tuple[AnyStatement, ...]"


@dataclass(slots=True)
class Repeat(Statement):
    body: "tuple[AnyStatement, ...]"
    until: Expression


@dataclass(slots=True)
class Try(Statement):
    """`__TRY body __CATCH(code) caught __FINALLY final __ENDTRY`; None for a part that is not there."""

    body: "tuple[AnyStatement, ...]"
    code: Expression | None
    caught: "tuple[AnyStatement, ...] | None"
    final: "tuple[AnyStatement, ...] | None"


AnyStatement = (
    Assign | CallStatement | Return | Exit | Continue | Empty | Label | Jump | If | Case | For | While | Repeat | Try
)
