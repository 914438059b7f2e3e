"""The tree of a source text, as it was written: declarations, Structured Text, Instruction List, and SFC.

Source: PacDrive manual 4.3 to 4.6 (lines 561 to 2936), IEC 61131-3 for what the manual leaves out.  Nothing is resolved
here; names keep the case of the source.  Positions and comments do not take part in comparisons, so that a printed and
parsed tree equals the first one.
"""

from dataclasses import dataclass, field
from enum import Enum
from typing import NamedTuple


class Place(NamedTuple):
    """A position in a source text, counted from 1."""

    line: int
    column: int


NOWHERE = Place(0, 0)


@dataclass(slots=True)
class Node:
    place: Place = field(default=NOWHERE, compare=False, repr=False, kw_only=True)


# ---- expressions


class LiteralKind(Enum):
    BOOL = "BOOL"
    INTEGER = "integer"
    REAL = "real number"
    STRING = "STRING"
    TIME = "TIME"
    DATE = "DATE"
    TOD = "TIME_OF_DAY"
    DT = "DATE_AND_TIME"


@dataclass(slots=True)
class Literal(Node):
    """A constant.  `value` is as at run time: times in ms, dates in s since 1970, a string without quotes."""

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
    """`of.5`: a single bit of an integer or bit string."""

    of: "Expression"
    number: int


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
    """`operator` is "-", "+" or "NOT"."""

    operator: str
    operand: "Expression"


@dataclass(slots=True)
class Binary(Node):
    """`operator` is one of + - * / ** MOD AND OR XOR AND_THEN OR_ELSE = <> < > <= >= ("&" is AND)."""

    operator: str
    left: "Expression"
    right: "Expression"


Expression = Literal | Name | Member | BitOf | Index | Dereference | Direct | Call | Unary | Binary


# ---- statements


@dataclass(slots=True)
class Statement(Node):
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    """Comments in front of the statement, with their brackets."""
    remark: str = field(default="", compare=False, repr=False, kw_only=True)
    """A comment behind the statement in its last line."""
    is_spaced: bool = field(default=False, compare=False, repr=False, kw_only=True)
    """True if an empty line precedes it."""
    after: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    """Comments behind the last statement of a block, in lines of their own."""


class AssignKind(Enum):
    PLAIN = ":="
    SET = "S="
    RESET = "R="
    REFER = "REF="


@dataclass(slots=True)
class Assign(Statement):
    target: Expression
    value: Expression
    kind: AssignKind = AssignKind.PLAIN


@dataclass(slots=True)
class CallStatement(Statement):
    call: Call


@dataclass(slots=True)
class Return(Statement):
    pass


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
class Range(Node):
    low: Expression
    high: Expression


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


AnyStatement = (
    Assign | CallStatement | Return | Exit | Continue | Empty | Label | Jump | If | Case | For | While | Repeat
)


# ---- Instruction List


@dataclass(slots=True)
class IlInstruction(Statement):
    """One line of IL: `label: OPERATOR operands`.

    `operator` is in capitals without modifiers, for example LD, AND, JMP; a function's name is an operator too, with
    the accumulator as its first argument.  `is_negated` is modifier N of an operand, or of the condition of a jump,
    call or return; `is_conditional` is modifier C.  `deferred` are the lines between an opening and a closing bracket.
    """

    operator: str
    operands: tuple[Expression, ...] = ()
    label: str = ""
    is_negated: bool = False
    is_conditional: bool = False
    deferred: "tuple[IlInstruction, ...] | None" = None


# ---- Sequential Function Chart


@dataclass(slots=True)
class ActionUse(Node):
    """An action at a step: `name(qualifier, time)`.  `qualifier` is one of N R S L D P SD DS SL P0 P1."""

    name: str
    qualifier: str = "N"
    time: Expression | None = None


@dataclass(slots=True)
class Step(Statement):
    """A step.  `entry`, `active` and `exit` are the actions of a simple step; `uses` are those of an IEC step."""

    name: str
    is_initial: bool = False
    uses: tuple[ActionUse, ...] = ()
    entry: "Body | None" = None
    active: "Body | None" = None
    exit: "Body | None" = None


@dataclass(slots=True)
class Transition(Statement):
    """A transition.  Several steps in `sources` are joined, several in `targets` are started at once.

    Transitions of the same source are tested in the order of `priority`, then of the text.
    """

    sources: tuple[str, ...]
    targets: tuple[str, ...]
    condition: Expression
    name: str = ""
    priority: int = 0


@dataclass(slots=True)
class StBody(Node):
    statements: tuple[AnyStatement, ...]


@dataclass(slots=True)
class IlBody(Node):
    instructions: tuple[IlInstruction, ...]


@dataclass(slots=True)
class SfcBody(Node):
    steps: tuple[Step, ...]
    transitions: tuple[Transition, ...]


@dataclass(slots=True)
class NativeBody(Node):
    """The body of a POU of a library that the controller implements; written as the pragma {native}."""


Body = StBody | IlBody | SfcBody | NativeBody


# ---- types


@dataclass(slots=True)
class NamedType(Node):
    name: str


@dataclass(slots=True)
class StringSpec(Node):
    length: Expression | None = None


@dataclass(slots=True)
class SubrangeSpec(Node):
    base: NamedType
    low: Expression
    high: Expression


@dataclass(slots=True)
class ArraySpec(Node):
    dimensions: tuple[Range, ...]
    element: "TypeSpec"


@dataclass(slots=True)
class PointerSpec(Node):
    to: "TypeSpec"
    is_reference: bool = False
    """True for REFERENCE TO."""


@dataclass(slots=True)
class EnumValue(Node):
    name: str
    value: Expression | None = None
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False, kw_only=True)
    remark: str = field(default="", compare=False, repr=False, kw_only=True)


@dataclass(slots=True)
class EnumSpec(Node):
    values: tuple[EnumValue, ...]
    base: str = ""
    """The integer type of the values; empty for INT."""


@dataclass(slots=True)
class StructSpec(Node):
    fields: "tuple[Variable, ...]"
    is_union: bool = False
    extends: str = ""
    """The structure that this one extends; empty for none."""


TypeSpec = NamedType | StringSpec | SubrangeSpec | ArraySpec | PointerSpec | EnumSpec | StructSpec


@dataclass(slots=True)
class Repeated(Node):
    """`count(value)` in the initial values of an array."""

    count: Expression
    value: "Initial"


@dataclass(slots=True)
class ArrayInitial(Node):
    elements: "tuple[Initial | Repeated, ...]"


@dataclass(slots=True)
class FieldInitial(Node):
    name: str
    value: "Initial"


@dataclass(slots=True)
class StructInitial(Node):
    fields: tuple[FieldInitial, ...]


Initial = Expression | ArrayInitial | StructInitial


# ---- declarations


@dataclass(slots=True)
class Variable(Statement):
    """One declared variable; `a, b : INT` makes two."""

    name: str
    type: TypeSpec
    initial: Initial | None = None
    location: Direct | None = None
    """The address behind AT.  An incomplete one, %I* of VAR_CONFIG programs, has no numbers."""


class Section(Enum):
    LOCAL = "VAR"
    TEMP = "VAR_TEMP"
    INPUT = "VAR_INPUT"
    OUTPUT = "VAR_OUTPUT"
    IN_OUT = "VAR_IN_OUT"
    EXTERNAL = "VAR_EXTERNAL"
    GLOBAL = "VAR_GLOBAL"
    CONFIG = "VAR_CONFIG"


@dataclass(slots=True)
class Variables(Statement):
    """A block VAR ... END_VAR.  In VAR_CONFIG the names are paths: `PROG.inst.var AT %QX0.0 : BOOL`."""

    section: Section
    variables: tuple[Variable, ...]
    is_retain: bool = False
    is_persistent: bool = False
    is_constant: bool = False
    name: str = field(default="", compare=False)
    """The name of a list of global variables; programs of today's tools may write `name.variable`."""


@dataclass(slots=True)
class TypeDeclaration(Statement):
    name: str
    type: TypeSpec
    initial: Initial | None = None


class PouKind(Enum):
    PROGRAM = "PROGRAM"
    FUNCTION = "FUNCTION"
    FUNCTION_BLOCK = "FUNCTION_BLOCK"


@dataclass(slots=True)
class Action(Statement):
    name: str
    body: Body


@dataclass(slots=True)
class Method(Statement):
    """A method of a function block or program, with variables of its own for each call."""

    name: str
    result: TypeSpec | None
    blocks: tuple[Variables, ...]
    body: Body
    modifiers: tuple[str, ...] = ()
    """Words such as PUBLIC, in capitals."""


@dataclass(slots=True)
class Pou(Statement):
    kind: PouKind
    name: str
    result: TypeSpec | None
    """The type of a function's result; None for other kinds."""
    blocks: tuple[Variables, ...]
    body: Body
    actions: tuple[Action, ...] = ()
    methods: tuple[Method, ...] = ()
    extends: str = ""
    """The function block that this one extends; empty for none."""
    end: Place = field(default=NOWHERE, compare=False, repr=False)


@dataclass(slots=True)
class TaskDeclaration(Statement):
    """`TASK name(INTERVAL := T#10ms, PRIORITY := 30);`, SINGLE for an event, neither for a free-running task."""

    name: str
    priority: Expression | None = None
    interval: Expression | None = None
    single: Expression | None = None


@dataclass(slots=True)
class ProgramInstance(Statement):
    """`PROGRAM name WITH task : type;`"""

    name: str
    task: str
    type: str


@dataclass(slots=True)
class Configuration(Statement):
    """CONFIGURATION ... END_CONFIGURATION, with its one resource, or RESOURCE parts without a configuration."""

    name: str
    blocks: tuple[Variables, ...] = ()
    tasks: tuple[TaskDeclaration, ...] = ()
    programs: tuple[ProgramInstance, ...] = ()
    resource: str = ""
    """The name of the resource; empty if the tasks belong to the configuration itself."""
    processor: str = ""
    """The name behind ON."""


Declaration = TypeDeclaration | Pou | Variables | Configuration


@dataclass(slots=True)
class Unit:
    """One source file.  `comments` are those behind its last declaration."""

    file: str
    declarations: tuple[Declaration, ...]
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False)
