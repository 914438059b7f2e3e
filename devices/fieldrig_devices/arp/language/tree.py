"""What an ARP program consists of, as read from its text.

Columns don't count when two trees are compared, so that a tree printed and read again is the same tree.  Division is
always `/`, whichever of its two signs the text has.  Names stand as they are; `resolve` puts what they mean.
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
    """PIG, HI, LO, ON, OFF."""

    word: str


@dataclass(frozen=True, slots=True)
class Name(Node):
    text: str


@dataclass(frozen=True, slots=True)
class Direct(Node):
    """V5, F10, I101, O104."""

    letter: str
    number: int


@dataclass(frozen=True, slots=True)
class Indexed(Node):
    """V[V1], F[COUNTER]; V[10] is read as V10."""

    letter: str
    index: Direct | Name


@dataclass(frozen=True, slots=True)
class System(Node):
    """@POS1 is ("@POS", 1); @PAR[5] is ("@PAR", None, 5), @PAR2[4] is ("@PAR", 2, 4)."""

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
    """SQR, INT, SEN, COS."""

    word: str
    operand: "Expression"


Resource: TypeAlias = Direct | Indexed | System | Name
Expression: TypeAlias = Number | Constant | Resource | Unary | Binary | Function


@dataclass(frozen=True, slots=True)
class Text(Node):
    """The string of MSG."""

    text: str


@dataclass(frozen=True, slots=True)
class Mode(Node):
    """E or P, the last word of TERM."""

    word: str


Argument: TypeAlias = Expression | Text | Mode

# ---- statements


@dataclass(frozen=True, slots=True)
class Read(Node):
    """What can only be read as a whole: ADC n, TIM n, ERROR, WARNING."""

    word: str
    number: Expression | None = None


@dataclass(frozen=True, slots=True)
class Assign(Node):
    target: Resource
    sign: str
    value: Expression | Read


@dataclass(frozen=True, slots=True)
class Goto(Node):
    """GOTO, or the label after the comma of IF."""

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
    """`edge` is empty, "!" (low), "/" (rising) or "\\" (falling)."""

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
    """Every instruction that is a word and its values (see `instructions`); `number` is that of CAMn and bare ONn."""

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
    """One source line that says something."""

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
    """Its first line."""
    end_number: int = field(compare=False)


@dataclass(frozen=True, slots=True)
class Program:
    """Routines in the order of the source, the main program first, and the EQU lines outside of them."""

    routines: tuple[Routine, ...]
    outside: tuple[Line, ...] = ()
