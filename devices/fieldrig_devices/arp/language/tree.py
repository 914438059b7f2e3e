"""The tree of an ARP program as it is read from text.

Comparison ignores columns, so that a tree that is printed and read again is equal.  Division is always `/`, whichever
of its two signs the text has.  Names are kept as written; `resolve` replaces them.
"""

from dataclasses import dataclass, field
from typing import TypeAlias


@dataclass(frozen=True, slots=True, kw_only=True)
class Node:
    column: int = field(default=0, compare=False)


# ---- expressions


@dataclass(frozen=True, slots=True)
class Number(Node):
    raw: int
    is_hex: bool = False


@dataclass(frozen=True, slots=True)
class Constant(Node):
    """One of the words PIG, HI, LO, ON and OFF."""

    word: str


@dataclass(frozen=True, slots=True)
class Name(Node):
    text: str


@dataclass(frozen=True, slots=True)
class Direct(Node):
    """A resource with a constant number: V5, F10, I101, O104."""

    letter: str
    number: int


@dataclass(frozen=True, slots=True)
class Indexed(Node):
    """A resource with a computed number: V[V1], F[COUNTER].  V[10] is read as V10."""

    letter: str
    index: Direct | Name


@dataclass(frozen=True, slots=True)
class System(Node):
    """A system variable: @POS1 is ("@POS", 1), @PAR[5] is ("@PAR", None, 5), @PAR2[4] is ("@PAR", 2, 4)."""

    word: str
    number: int | None = None
    index: int | None = None


@dataclass(frozen=True, slots=True)
class Unary(Node):
    sign: str
    operand: "Expression"


@dataclass(frozen=True, slots=True)
class Binary(Node):
    sign: str
    left: "Expression"
    right: "Expression"


@dataclass(frozen=True, slots=True)
class Function(Node):
    """A call of SQR, INT, SEN or COS."""

    word: str
    operand: "Expression"


Resource: TypeAlias = Direct | Indexed | System | Name
Expression: TypeAlias = Number | Constant | Resource | Unary | Binary | Function


@dataclass(frozen=True, slots=True)
class Text(Node):
    """The string of a MSG instruction."""

    text: str


@dataclass(frozen=True, slots=True)
class Mode(Node):
    """The mode of TERM, E or P."""

    word: str


Argument: TypeAlias = Expression | Text | Mode

# ---- statements


@dataclass(frozen=True, slots=True)
class Read(Node):
    """A value that may only be assigned by itself: ADC n, TIM n, ERROR, WARNING."""

    word: str
    number: Expression | None = None


@dataclass(frozen=True, slots=True)
class Assign(Node):
    target: Resource
    sign: str
    value: Expression | Read


@dataclass(frozen=True, slots=True)
class Goto(Node):
    """A GOTO instruction, or the label after the comma of an IF."""

    label: str
    is_bare: bool = False


@dataclass(frozen=True, slots=True)
class Call(Node):
    routine: str


@dataclass(frozen=True, slots=True)
class If(Node):
    left: Expression
    relation: str
    right: Expression
    then: "Statement"


@dataclass(frozen=True, slots=True)
class BitCondition(Node):
    """A condition on one bit; `edge` is empty, "!" (low), "/" (rising) or "\\" (falling)."""

    edge: str
    bit: Resource


@dataclass(frozen=True, slots=True)
class PositionCondition(Node):
    axis: Expression
    relation: str
    variable: Resource


@dataclass(frozen=True, slots=True)
class OnEvent(Node):
    number: int
    enable: Resource
    condition: BitCondition | PositionCondition
    routine: str


@dataclass(frozen=True, slots=True)
class Command(Node):
    """A word and its values (see `instructions`); `number` is the n of CAMn and of a bare ONn."""

    word: str
    arguments: tuple[Argument, ...] = ()
    number: int | None = None


Statement: TypeAlias = Assign | Goto | Call | If | OnEvent | Command


@dataclass(frozen=True, slots=True)
class Equ(Node):
    name: str
    meaning: Resource | Number


@dataclass(frozen=True, slots=True)
class Line:
    """A source line with content."""

    number: int = field(compare=False)
    label: str | None = None
    content: Statement | Equ | None = None
    label_column: int = field(default=0, compare=False)


@dataclass(frozen=True, slots=True)
class Routine:
    name: str
    is_interrupt: bool
    lines: tuple[Line, ...]
    number: int = field(compare=False)
    """Number of its first line."""
    end_number: int = field(compare=False)


@dataclass(frozen=True, slots=True)
class Program:
    """The routines in source order, the main program first, and the EQU lines outside of routines."""

    routines: tuple[Routine, ...]
    outside: tuple[Line, ...] = ()
