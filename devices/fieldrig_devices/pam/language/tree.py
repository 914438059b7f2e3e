"""The tree of expressions and statements.

`Index` is how an object of several items is named: `i` is the present item, `all` each of them, `all+` and `all*` the
OR and the AND over them (rows PAML-245, PAML-246).
"""

from dataclasses import dataclass, field
from typing import Literal, NamedTuple

Index = Literal["i", "all", "all+", "all*"]


class Place(NamedTuple):
    """A position in the sources."""

    file: str
    line: int
    column: int


@dataclass(frozen=True, slots=True)
class Node:
    place: Place = field(compare=False)


# ---- expressions


@dataclass(frozen=True, slots=True)
class Number(Node):
    value: int | float
    spelling: str = field(compare=False, default="")
    """The text of the source, which messages show."""


@dataclass(frozen=True, slots=True)
class Text(Node):
    value: str


@dataclass(frozen=True, slots=True)
class Word(Node):
    """A symbolic value such as RISING, the constant Pi, or the flag TIMEOUT."""

    name: str


@dataclass(frozen=True, slots=True)
class Reference(Node):
    """The name of an object or of a formal parameter."""

    name: str
    index: Index | None = None


@dataclass(frozen=True, slots=True)
class ParameterOf(Node):
    """The parameter of an object, as in AXI_Belt:TRAVEL_SPEED."""

    subject: Reference
    parameter: str


@dataclass(frozen=True, slots=True)
class Unary(Node):
    operator: Literal["+", "-", "!"]
    operand: "Expression"


@dataclass(frozen=True, slots=True)
class Binary(Node):
    operator: str
    left: "Expression"
    right: "Expression"


@dataclass(frozen=True, slots=True)
class Inquiry(Node):
    """A question to an object or value, as in AXI_Belt ? ready."""

    subject: "Expression"
    function: str
    arguments: tuple["Expression", ...] = ()


@dataclass(frozen=True, slots=True)
class Reduction(Node):
    """An expression over all items in parentheses, as in (IFV_a[i] * IFV_b[i])[all+]."""

    operand: "Expression"
    index: Literal["all+", "all*"]


Expression = Number | Text | Word | Reference | ParameterOf | Unary | Binary | Inquiry | Reduction


@dataclass(frozen=True, slots=True)
class RoutineCall(Node):
    """A routine with its arguments, or NONE with an empty name, as CALL and the comparators name it."""

    routine: str
    arguments: tuple[Expression, ...] = ()


# ---- statements


@dataclass(frozen=True, slots=True)
class Assign(Node):
    target: Reference
    value: Expression


@dataclass(frozen=True, slots=True)
class Execute(Node):
    """An executive function, as in AXI_Belt <- run(5.0)."""

    target: Reference
    function: str
    arguments: tuple[Expression, ...] = ()


@dataclass(frozen=True, slots=True)
class Modify(Node):
    """A parameter gets a value, as in AXI_Belt:ACCELERATION <- 3."""

    target: ParameterOf
    value: Expression | RoutineCall


@dataclass(frozen=True, slots=True)
class Ask(Node):
    """An inquiry whose answer is not used; it is legal and without effect (manual line 3460)."""

    inquiry: Expression


@dataclass(frozen=True, slots=True)
class Connect(Node):
    """A pipe is made and activated: from the output block to the input block (PAML-403)."""

    blocks: tuple[Reference, ...]


@dataclass(frozen=True, slots=True)
class Call(Node):
    call: RoutineCall


@dataclass(frozen=True, slots=True)
class If(Node):
    condition: Expression
    then: tuple["Statement", ...]
    otherwise: tuple["Statement", ...] = ()


@dataclass(frozen=True, slots=True)
class Loop(Node):
    body: tuple["Statement", ...]
    until: Expression


@dataclass(frozen=True, slots=True)
class SequenceRef(Node):
    name: str
    is_indexed: bool = False


@dataclass(frozen=True, slots=True)
class StartSequence(Node):
    sequence: SequenceRef


@dataclass(frozen=True, slots=True)
class StartTask(Node):
    """XEQ_TASK; the mode is empty, WAIT or ABORT (PAML-323 to 325)."""

    task: str
    sequence: SequenceRef
    mode: Literal["", "WAIT", "ABORT"] = ""


@dataclass(frozen=True, slots=True)
class Condition(Node):
    condition: Expression
    timeout: Expression | None = None
    """In milliseconds."""


@dataclass(frozen=True, slots=True)
class DuplicateStart(Node):
    """CONDITION DUPL_START, the gate of a task with several copies (PAML-354)."""


@dataclass(frozen=True, slots=True)
class Wait(Node):
    duration: Expression
    """In milliseconds."""


@dataclass(frozen=True, slots=True)
class Branch(Node):
    """A CONDITION of a CASE with the sequence that it starts; `condition` of the last may be a time-out in ms."""

    condition: Expression
    sequence: SequenceRef


@dataclass(frozen=True, slots=True)
class Case(Node):
    branches: tuple[Branch, ...]
    timeout: Branch | None = None


@dataclass(frozen=True, slots=True)
class EntryAction(Node):
    label: str


@dataclass(frozen=True, slots=True)
class AbortAction(Node):
    pass


ExceptionAction = StartSequence | StartTask | EntryAction | AbortAction


@dataclass(frozen=True, slots=True)
class ArmException(Node):
    """EXCEPTION.  TIMEOUT without a value takes over what is left of the one before it (PAML-379)."""

    condition: Expression
    action: ExceptionAction
    has_timeout: bool = False
    timeout: Expression | None = None


@dataclass(frozen=True, slots=True)
class ExceptionEntry(Node):
    label: str


@dataclass(frozen=True, slots=True)
class RemoveException(Node):
    pass


ActiveStatement = Assign | Execute | Modify | Ask | Connect | Call | If | Loop | StartSequence | StartTask
ServiceStatement = Condition | DuplicateStart | Wait | Case | ArmException | ExceptionEntry | RemoveException
Statement = ActiveStatement | ServiceStatement
