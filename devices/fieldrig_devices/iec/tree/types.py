"""Types, start values, and declared variables."""

from dataclasses import dataclass, field

from fieldrig_devices.iec.tree.expressions import Argument, Direct, Expression, Range
from fieldrig_devices.iec.tree.nodes import Node, Statement


@dataclass(slots=True)
class NamedType(Node):
    name: str
    arguments: tuple[Argument, ...] = ()
    """The arguments of FB_init, `motor : Motor(number := 3);`."""
    rows: tuple[tuple[Argument, ...], ...] = ()
    """The same for each element of an array, `ARRAY[1..2] OF Motor[(number := 3), (number := 4)]`."""
    parameters: tuple[Expression, ...] = ()
    """The generic constants of a function block, `Stack<10>`."""


@dataclass(slots=True)
class StringSpec(Node):
    length: Expression | None = None
    is_wide: bool = False
    """True for a WSTRING."""


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
class OpenArraySpec(Node):
    """`ARRAY[*, *] OF element`, an argument whose limits are those of the array that is passed."""

    count: int
    """The number of dimensions."""
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


TypeSpec = NamedType | StringSpec | SubrangeSpec | ArraySpec | OpenArraySpec | PointerSpec | EnumSpec | StructSpec


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


@dataclass(slots=True)
class Variable(Statement):
    """One declared variable; `a, b : INT` makes two."""

    name: str
    type: TypeSpec
    initial: Initial | None = None
    location: Direct | None = None
    """The address behind AT.  An incomplete one, %I* of VAR_CONFIG programs, has no numbers."""
    edge: str = ""
    """R_EDGE or F_EDGE."""
    narrow: TypeSpec | None = None
    """The smaller type of the result of arithmetic in 32 bits that a variable of a drawing holds."""
    place: str = ""
    """The point or the wire of a rig behind AT, in a test; empty for none."""
