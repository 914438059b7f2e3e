"""A checked program: every name is a variable, every expression has a type, every conversion is explicit.

`check` makes it from the tree of the source (`tree.py`), and `lower` turns it into Python.  Instruction List and SFC
are statements here already, so the rest knows one form only.  A program, function block, function or action is a `Pou`.

    expressions, each with its `type`        Constant, Load, Unary, Binary, Convert, Intrinsic, CallFunction, Enabled,
                                             AddressOf, Description, Allocate, Assigned
    places, which are read and written       Cell, Element, OpenElement, Component, Target, This, Result, Kept, Swapped,
                                             Located, Parameter, Bit
    statements, each with its source line    Assign, Evaluate, CallBlock, CallAction, If, Case, For, Loop, Exit,
                                             Continue, Return, Label, Jump, Free, Try

It is one file because all of these are made of each other: an index is an expression in a place, a load is a place in
an expression, and a call has a `Pou`, which has statements.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.tree import NOWHERE, Node, Position, PouKind, Section
from fieldrig_devices.iec.types import (
    BlockType,
    EnumType,
    InitialValue,
    ObjectType,
    OpenArrayType,
    PointerType,
    StringType,
    StructType,
    SubrangeType,
    Type,
    Value,
)

CLASS: Final = "$class"
"""The name of the hidden word that tells the function block of an instance."""


class Space(Enum):
    """The memory that a variable is in, and that its address counts from."""

    GLOBAL = "global"
    """At a fixed address: global variables, programs, and the instances in them."""
    INSTANCE = "instance"
    """In the memory of the instance whose code runs: variables of a function block or program."""
    FRAME = "frame"
    """On the stack of the running task: arguments, result and variables of a function, and VAR_TEMP."""


@dataclass(slots=True, eq=False)
class Variable:
    """One variable.  `offset` is filled in by `layout`; it counts from the start of its space."""

    name: str
    type: Type
    space: Space
    section: Section
    initial: InitialValue | None = None
    """None: the initial value of the type."""
    is_retain: bool = False
    is_constant: bool = False
    location: "Located | None" = None
    """The address behind AT; the variable has no cell then."""
    offset: int = -1
    position: Position = NOWHERE
    file: str = ""
    comment: str = ""
    is_fixed: bool = False
    """True for VAR_INPUT CONSTANT: a call gives it, and its POU only reads it."""
    narrow: Type | None = None
    """The type of the operands, in a hidden variable that holds the result of arithmetic with all of its 32 bits."""

    @property
    def is_reference(self) -> bool:
        """True for VAR_IN_OUT and ARRAY[*]: its cell contains the address of the argument."""
        return self.section is Section.IN_OUT or type(self.type) is OpenArrayType


# ---- places


@dataclass(slots=True)
class Cell:
    """A variable itself; for a VAR_IN_OUT, its argument."""

    variable: Variable
    type: Type


@dataclass(slots=True)
class Element:
    """An element of an array.  An index outside `low`..`high` is a fault at run time; `stride` is in bytes."""

    of: "Place"
    index: "Expression"
    low: int
    high: int
    stride: int
    type: Type


@dataclass(slots=True)
class OpenElement:
    """An element of an ARRAY[*], whose limits and stride are known at run time."""

    of: "Place"
    index: "Expression"
    array: OpenArrayType
    type: Type


@dataclass(slots=True)
class Component:
    """A field of a structure, or a variable of an instance: `variable.offset` or `offset` bytes behind `of`."""

    of: "Place"
    offset: int
    type: Type
    variable: Variable | None = None
    """The variable of an instance, whose offset `layout` sets; then `offset` is not used."""


@dataclass(slots=True)
class Target:
    """The target of a pointer.  A pointer to nothing, or to something of another form, is looked at at run time."""

    pointer: "Expression"
    type: Type


@dataclass(slots=True)
class This:
    """The instance whose code runs, which `THIS^` means."""

    type: Type


@dataclass(slots=True)
class Result:
    """The result of a call of which a part is read; lowering puts the cell in its place that the call leaves it in."""

    call: "CallFunction"

    @property
    def type(self) -> Type:
        return self.call.type


@dataclass(slots=True)
class Kept:
    """A value that is stored in a hidden variable first, so that it has an address."""

    value: "Expression"
    variable: Variable

    @property
    def type(self) -> Type:
        return self.variable.type


@dataclass(slots=True)
class Swapped:
    """A structure or an array with the bytes of each of its elementary values in the opposite order.

    It has no address: it is read as a whole, into a hidden variable (`Kept`).
    """

    of: "Place"

    @property
    def type(self) -> Type:
        return self.of.type


@dataclass(slots=True)
class Located:
    """A directly represented variable, as in PD-364: `byte` counts bytes of the area, `bit` is -1 without X."""

    area: str
    """I, Q or M."""
    byte: int
    bit: int
    type: Type


@dataclass(slots=True)
class Parameter:
    """A parameter of a configuration object.  `object` yields the logical address; a Constant for a named object."""

    object: "Expression"
    object_type: ObjectType
    number: int
    type: Type
    is_slow: bool = False
    is_writable: bool = False


@dataclass(slots=True)
class Bit:
    """Bit `number` of an integer or bit string."""

    of: "Place"
    number: int
    type: Type = Elementary.BOOL


Place = Cell | Element | OpenElement | Component | Target | This | Result | Kept | Swapped | Located | Parameter | Bit


# ---- expressions


@dataclass(slots=True)
class Constant:
    value: Value
    type: Type


@dataclass(slots=True)
class Load:
    place: Place

    @property
    def type(self) -> Type:
        return self.place.type


class Operator(Enum):
    ADD = "+"
    SUB = "-"
    MUL = "*"
    DIV = "/"
    MOD = "MOD"
    AND = "AND"
    OR = "OR"
    XOR = "XOR"
    AND_THEN = "AND_THEN"
    OR_ELSE = "OR_ELSE"
    EQ = "="
    NE = "<>"
    LT = "<"
    LE = "<="
    GT = ">"
    GE = ">="
    NEG = "unary -"
    NOT = "NOT"


COMPARISONS: Final = frozenset({Operator.EQ, Operator.NE, Operator.LT, Operator.LE, Operator.GT, Operator.GE})


@dataclass(slots=True)
class Unary:
    operator: Operator
    operand: "Expression"
    type: Type


@dataclass(slots=True)
class Binary:
    """Both operands have the same type, except for TIME * number and TIME / number.

    The result is computed in `type`, with its overflow: integers wrap around, REAL is rounded to single precision after
    each operation.  A comparison has type BOOL.  Both operands are always evaluated, apart from AND_THEN and OR_ELSE.
    """

    operator: Operator
    left: "Expression"
    right: "Expression"
    type: Type


@dataclass(slots=True)
class Convert:
    """The value in another elementary type, by the rules of `library/conversions.py`, such as REAL_TO_INT."""

    operand: "Expression"
    type: Type
    is_narrowing: bool = False
    """True for the result of arithmetic in 32 bits in the type of its operands, INT for INT + INT: it is cut where it
    is stored, but a larger type takes the operand itself."""


@dataclass(slots=True)
class Intrinsic:
    """A standard function without state, from `library/intrinsics.py`: ABS, SHL, LIMIT, CONCAT and so on.

    `name` is the name of the implementation for these types; arguments have exactly the types that it expects.
    """

    name: str
    arguments: "tuple[Expression, ...]"
    type: Type


@dataclass(slots=True)
class CallFunction:
    """A call of a FUNCTION, of the user or of a library.

    `inputs` has an entry for each VAR_INPUT and VAR_IN_OUT, in the order of their declaration; defaults are filled in.
    """

    pou: "Pou"
    inputs: "tuple[tuple[Variable, Expression | Place], ...]"
    type: Type
    outputs: "tuple[tuple[Variable, Place, Expression], ...]" = ()
    """Assignments after the call, as (output, target, value), where the value has the cell of the output in it."""
    instance: "Place | None" = None
    """The instance whose method is called; None for a function, and for the instance whose code runs."""


@dataclass(slots=True)
class Enable:
    """EN and ENO of a call."""

    condition: "Expression | None" = None
    """EN; None if the call always runs."""
    ok: "Place | None" = None
    """The BOOL that ENO is assigned to."""
    is_negated: bool = False
    """True if `ok` gets NOT ENO."""


@dataclass(slots=True)
class Enabled:
    """The result of a call with EN or ENO; without EN it is the start value of its type."""

    value: "Expression"
    enable: Enable

    @property
    def type(self) -> Type:
        return self.value.type


@dataclass(slots=True)
class AddressOf:
    """ADR(place), or the reference that is passed to a VAR_IN_OUT."""

    place: Place
    type: Type


@dataclass(slots=True)
class Description:
    """The argument for an input of type ANY: class, address and size of what is at a place (`any_types.py`)."""

    place: Place
    type_class: int
    type: Type


@dataclass(slots=True)
class Allocate:
    """The address of new memory for variables of type `of`, with their start values; 0 if there is none."""

    of: Type
    count: "Expression"
    type: Type


@dataclass(slots=True)
class Assigned:
    """The value of a place once another value has been assigned to it."""

    place: Place
    value: "Expression"

    @property
    def type(self) -> Type:
        return self.place.type


Expression = (
    Constant
    | Load
    | Unary
    | Binary
    | Convert
    | Intrinsic
    | CallFunction
    | Enabled
    | AddressOf
    | Description
    | Allocate
    | Assigned
)


# ---- statements


@dataclass(slots=True)
class Statement:
    line: int = field(kw_only=True)
    """The source line, in the file of the POU."""
    origin: Node | None = field(default=None, kw_only=True, compare=False, repr=False)
    """The statement, step or transition of the source that begins here; None for what the compiler adds."""


@dataclass(slots=True)
class Assign(Statement):
    """Both sides have the same type; a string is cut to the length of the target, a structure or array is copied."""

    place: Place
    value: Expression


@dataclass(slots=True)
class Evaluate(Statement):
    """A function called for its effects only."""

    value: CallFunction | Enabled


@dataclass(slots=True)
class CallBlock(Statement):
    """A call of an instance of a function block, or of a program.

    Inputs that are not given keep their values; then the body runs, then `outputs` are assigned.
    """

    instance: Place
    pou: "Pou"
    inputs: tuple[tuple[Variable, Expression], ...] = ()
    references: tuple[tuple[Variable, Place], ...] = ()
    """Arguments of VAR_IN_OUT."""
    outputs: tuple[tuple[Place, Expression], ...] = ()
    """Assignments after the call, as (target, Load of the output)."""
    enable: Enable = field(default_factory=Enable)
    """EN and ENO; while EN is FALSE, nothing of the call happens apart from ENO."""


@dataclass(slots=True)
class CallAction(Statement):
    """A call of an action of an instance; of the same instance if `instance` is None."""

    pou: "Pou"
    instance: Place | None = None


@dataclass(slots=True)
class If(Statement):
    condition: Expression
    then: "list[AnyStatement]"
    otherwise: "list[AnyStatement]" = field(default_factory=list)


@dataclass(slots=True)
class Case(Statement):
    """`branches` are (ranges, body); a range is (lowest, highest)."""

    selector: Expression
    branches: "list[tuple[tuple[tuple[int, int], ...], list[AnyStatement]]]"
    otherwise: "list[AnyStatement]" = field(default_factory=list)


@dataclass(slots=True)
class For(Statement):
    """`last` and `step` are evaluated before each pass, as CoDeSys does; the sign of the step decides on the test."""

    variable: Place
    first: Expression
    last: Expression
    step: Expression
    body: "list[AnyStatement]"


@dataclass(slots=True)
class Loop(Statement):
    """WHILE (`until` is None) or REPEAT (`condition` is None)."""

    body: "list[AnyStatement]"
    condition: Expression | None = None
    until: Expression | None = None


@dataclass(slots=True)
class Exit(Statement):
    pass


@dataclass(slots=True)
class Continue(Statement):
    pass


@dataclass(slots=True)
class Return(Statement):
    pass


@dataclass(slots=True)
class Label(Statement):
    name: str


@dataclass(slots=True)
class Jump(Statement):
    """Jump to a label of the same body, always or if `condition` holds."""

    label: str
    condition: Expression | None = None


@dataclass(slots=True)
class Free(Statement):
    """Give the memory at an address back."""

    address: Expression


@dataclass(slots=True)
class Try(Statement):
    """`caught` runs after a fault in `body`, whose number goes to `code`, and `final` in any case.

    `caught` or `final` is None if the program does not have it.
    """

    body: "list[AnyStatement]"
    code: Place | None
    caught: "list[AnyStatement] | None"
    final: "list[AnyStatement] | None"


AnyStatement = (
    Assign
    | Evaluate
    | CallBlock
    | CallAction
    | If
    | Case
    | For
    | Loop
    | Exit
    | Continue
    | Return
    | Label
    | Jump
    | Free
    | Try
)


# ---- the whole


@dataclass(slots=True, eq=False)
class Pou:
    """A program, function block, function, or action, with its variables and its body."""

    kind: PouKind
    name: str
    """The name as declared; an action is `Pou.Action`."""
    file: str
    variables: dict[str, Variable] = field(default_factory=dict)
    """Keyed by the name in small letters, in the order of declaration; an action has those of its POU."""
    result: Variable | None = None
    """The result of a function; first cell of its frame."""
    eno: Variable | None = None
    """The ENO that the body sets; None if it is always that of the call."""
    type: BlockType | None = None
    """The type of its instances, for programs and function blocks."""
    instance: Variable | None = None
    """The one instance of a program, a global variable."""
    body: list[AnyStatement] = field(default_factory=list)
    actions: "dict[str, Pou]" = field(default_factory=dict)
    methods: "dict[str, Pou]" = field(default_factory=dict)
    """Methods are functions with an owner, and like functions they are in `Program.pous`, by `pou.method`."""
    owner: "Pou | None" = None
    """The POU that an action or a method belongs to."""
    is_native: bool = False
    """True for a POU of a library that the host implements."""
    is_accessor: bool = False
    """True for a method that reads or writes a property."""
    also: frozenset[str] = frozenset()
    """The interfaces that its instances implement, and the blocks that it extends, by their names in small letters."""
    frame_size: int = 0
    """Bytes on the stack, from `layout`, without intermediate results."""

    @property
    def is_method(self) -> bool:
        return self.kind is PouKind.FUNCTION and self.owner is not None and self.owner.kind is not PouKind.FUNCTION


class TaskKind(Enum):
    CYCLIC = "cyclic"
    FREE = "free-running"
    EVENT = "event"


@dataclass(slots=True)
class Task:
    """A task of the task configuration (PD-060)."""

    name: str
    kind: TaskKind
    priority: int
    """0 (highest) to 31 (PD-061)."""
    interval_ms: float
    """The interval of cyclic tasks."""
    event: Variable | None
    """A BOOL whose rising edge starts an event task."""
    programs: "list[Pou]"
    file: str = ""
    line: int = 0
    is_default: bool = False
    """True for the task that is made because there is no task configuration."""
    instances: "dict[str, Pou]" = field(default_factory=dict)
    """The programs by the names of their instances, as keys of the tables."""


@dataclass(frozen=True, slots=True)
class Link:
    """An address of VAR_CONFIG for a variable of one instance, whose other instances have other addresses.

    The code is the same for all instances, so the variable has a cell, which is exchanged with the address at both ends
    of each cycle.
    """

    path: str
    variable: Variable
    where: Located


@dataclass(slots=True)
class Program:
    """Everything that a project declares."""

    pous: dict[str, Pou]
    """Keyed by the name in small letters, with the library's; actions are in their POU."""
    globals: dict[str, Variable]
    """Keyed by the name in small letters; instances of programs are among them."""
    types: Mapping[str, StructType | EnumType | SubrangeType | StringType | PointerType | Type]
    """Declared types by the name in small letters."""
    tasks: list[Task]
    objects: Mapping[str, "ConfiguredObject"] = field(default_factory=dict)
    links: Sequence[Link] = ()
    dialect: Dialect = EPAS_4
    """Its `key` gives the keys of the tables: small letters, and in EPAS-4 the first 32 of them (PD-350)."""


@dataclass(frozen=True, slots=True)
class ConfiguredObject:
    """An object of the control configuration that programs can name, and `_Name` for its logical address (PD-025)."""

    name: str
    type: ObjectType
    address: int
