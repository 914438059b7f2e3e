"""Everything that the project declares, by name, while it is being checked."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol

from fieldrig_devices.iec import program, tree
from fieldrig_devices.iec.check.extension import Extension
from fieldrig_devices.iec.check.reports import Keys, Reports
from fieldrig_devices.iec.dialect import Dialect
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.host import Host
from fieldrig_devices.iec.limits import Limits
from fieldrig_devices.iec.program import Component, Constant, Element, Pou, Variable
from fieldrig_devices.iec.tree import Action
from fieldrig_devices.iec.types import EnumType, Field, InitialValue, StringType, StructType, SubrangeType, Type, Value

WINDOW: Final = 256
"""Bytes of the addresses with the same leading levels, as much as a Modbus request can have."""
START: Final = "$start"
"""The name of the methods and functions that run before the first cycle."""
UNKNOWN: Type = StructType("an unknown type")
"""The type of what a mistake was reported for already; nothing more is said about it."""


@dataclass(slots=True)
class Addresses:
    """Which parts of the areas %I, %Q and %M are used by addresses with one number, and by those with levels."""

    ends: dict[str, int] = field(default_factory=dict)
    """The first byte behind all addresses with one number, by the letter of the area."""
    _windows: dict[tuple[str, tuple[int, ...]], int] = field(default_factory=dict)

    def window(self, area: str, levels: tuple[int, ...], size: int) -> int | None:
        """Return the first byte of the window for these leading levels; None if the area has no room for it.

        `size` is that of the area in bytes.
        """
        key = area, levels
        if key not in self._windows:
            start = self.windows_from(area, size) - WINDOW
            if start < self.ends.get(area, 0):
                return None
            self._windows[key] = start
        return self._windows[key]

    def windows_from(self, area: str, size: int) -> int:
        """Return the byte from which on the windows of the area are."""
        return size - WINDOW * sum(1 for known, _ in self._windows if known == area)


@dataclass(slots=True)
class Pending:
    """A name whose meaning is worked out when it is first used: a global variable, an enumeration value."""

    make: "Callable[[], Entity]"
    is_busy: bool = False


Entity = Variable | Constant | Pou | EnumType
"""The possible meanings of a name in an expression."""


@dataclass(frozen=True, slots=True)
class Guard:
    """An access specifier, and the function block or class that wrote it."""

    word: str
    level: int
    """How many steps it is above the function block that has the variable or method."""
    home: str


@dataclass(slots=True)
class Lineage:
    """The trees of a function block and of those that it extends, each with its file; the next one comes first."""

    trees: list[tuple[tree.Pou, str]]
    versions: dict[str, list[tuple[int, Pou]]] = field(default_factory=dict)
    """The methods by name with their levels, the valid one first."""
    is_broken: bool = False
    """True if a function block that it extends is not known, so that names of that one may be used."""


@dataclass(frozen=True, slots=True)
class Edge:
    """An input with R_EDGE or F_EDGE, and two hidden variables of the instance."""

    input: Variable
    seen: Variable
    """The variable that the body means by the name of the input."""
    before: Variable
    """The signal of the previous call: the input itself, or its opposite for falling edges."""
    is_falling: bool


@dataclass(frozen=True, slots=True)
class Pins:
    """The parameters of a POU; the names are in the form in which names are compared."""

    inputs: dict[str, Variable]
    outputs: dict[str, Variable]
    placed: Sequence[Variable]
    """The parameters that arguments without names belong to, in their order."""


@dataclass(slots=True, eq=False)
class PouSource:
    """A POU and where it comes from."""

    pou: Pou
    tree: tree.Pou
    is_library: bool
    names: dict[str, Variable] = field(default_factory=dict)
    """The meanings of its own names: its variables, those behind VAR_EXTERNAL, and the result of a function."""
    inputs: list[Variable] = field(default_factory=list)
    """VAR_INPUT and VAR_IN_OUT, in the order of their declaration."""
    outputs: list[Variable] = field(default_factory=list)
    edges: list[Edge] = field(default_factory=list)
    outer: "PouSource | None" = None
    """The function block or program of a method, whose names it knows too."""
    line: "Lineage | None" = None
    """The function blocks that this one extends; None for other POUs."""
    level: int = 0
    """How many steps above the function block a method was declared."""
    actions: "dict[str, tuple[Action, int]]" = field(default_factory=dict)
    """The actions, with those that are inherited and the levels at which they were declared."""


@dataclass(slots=True, eq=False)
class Start:
    """A start value that has not been computed yet."""

    variable: Variable
    initial: tree.Initial
    source: PouSource | None
    file: str
    is_busy: bool = False
    is_done: bool = False


def start_of(kind: Type) -> Value | None:
    """Return the start value of a type without a declared one (PD-056); None for arrays, structures and references."""
    if isinstance(kind, Elementary):
        return kind.initial
    if isinstance(kind, StringType):
        return ""
    if isinstance(kind, EnumType):
        return next(iter(kind.values.values()), 0)
    if isinstance(kind, SubrangeType):
        return 0 if kind.low <= 0 <= kind.high else kind.low
    return None


class Types(Protocol):
    """The declared types: `TypeSpecs`."""

    def resolve(self, spec: tree.TypeSpec, context: Any) -> Type:
        """Return the type; UNKNOWN after a message."""


class Starter(Protocol):
    """The part of the checker that starts instances: `Startup`."""

    def of_new(self, target: tree.Expression, kind: Type, spec: tree.TypeSpec) -> Iterator[tree.AnyStatement]:
        """Yield the statements that start what a pointer points to."""


class Project:
    def __init__(self, host: Host, dialect: Dialect, limits: Limits, extension: Extension | None = None) -> None:
        self.host, self.dialect, self.limits = host, dialect, limits
        self.extension = extension
        self.reports = Reports()
        self.addresses = Addresses()
        self.guards: dict[Variable | Pou, Guard] = {}
        """The variables and methods with an access specifier."""
        self.properties: set[str] = set()
        """The names of all properties."""
        self.interfaces: dict[str, tuple[tree.Interface, str]] = {}
        """The interfaces by name, each with its file."""
        self.facades: dict[str, Pou] = {}
        """The blocks with dispatchers for the methods of interfaces, by the name of the interface."""
        self.inherited = 0
        """How many variables and methods function blocks have inherited so far."""
        self.inherits_too_much = False
        self.extended: set[str] = set()
        """The names of the function blocks that others extend."""
        self.key = Keys(dialect).__getitem__
        self.names: dict[str, Entity | Pending] = {}
        self.declared_at: dict[str, tuple[str, tree.Position]] = {}
        self.shadowed: dict[str, Entity] = {}
        """The meanings of such names in the libraries, if the project has redefined them."""
        self.library_names: set[str] = set()
        """Names of libraries, which the project may redefine."""
        self.pous: dict[str, Pou] = {}
        self.sources: dict[Pou, PouSource] = {}
        self.globals: dict[str, Variable] = {}
        self.lists: dict[str, dict[str, str]] = {}
        """The names in each named list of global variables, for `list.variable` of today's tools, each with the name by
        which the project knows the variable."""
        self.types: dict[str, Type] = {}
        self.unfinished: set[Type] = set()
        """Structures some of whose components are not known yet, and so their sizes."""
        self.defaults: dict[str, InitialValue] = {}
        """Start values of declared types, by name."""
        self.starts: dict[Variable, Start] = {}
        self.computed: dict[Variable, Start] = {}
        """The start values that are computed when the program starts."""
        self.declared: dict[Variable, tree.Variable] = {}
        """The declarations of variables."""
        self.compute: Callable[[Start], None] = lambda start: None
        """Works out a start value; set by the checker."""
        self.enumerated: dict[str, list[EnumType]] = {}
        """The enumerations that have a value of a name, which may be that of a POU too."""
        self.enumerations: dict[EnumType, Callable[[], None]] = {}
        """Enumerations whose numbers have not been worked out yet."""
        self.depth = 0
        """Start values that wait for the one that is being worked out."""
        self.makers: dict[Type, Pou] = {}
        """The functions behind __NEW by type."""
        self.preludes: dict[Pou, list[program.AnyStatement]] = {}
        """The statements in front of the bodies that have no text."""
        self.strides: list[tuple[Constant, Type]] = []
        """The sizes of what pointers are indexed by, which may still grow like those of elements."""
        self.specs: Types | None = None
        """The declared types; set by the declarations."""
        self.startup: Starter | None = None
        """The checker sets it."""
        self.tasks: list[program.Task] = []
        self.pins: dict[tuple[Pou, int, int], Pins] = {}
        """The parameters of calls by what is called, and by how many inputs and outputs it has."""
        self.calls: dict[Pou, dict[Pou, tree.Position]] = {}
        """Which POU calls which, with the position of one call."""
        self.elements: list[Element] = []
        """Elements whose stride may still grow by hidden variables of function blocks."""
        self.components: list[tuple[Component, Field]] = []

    def find(self, name: str) -> Entity | None:
        """Return what the name means in the whole project; None for an unknown name or one that is being worked out."""
        entity = self.names.get(name)
        if type(entity) is not Pending:
            return entity  # type: ignore[return-value]
        if entity.is_busy:
            return None
        entity.is_busy = True
        self.names[name] = made = entity.make()
        return made

    def declare(self, name: str, entity: Entity | Pending, file: str, position: tree.Position) -> None:
        """Give a name its meaning in the whole project; the caller has made sure that it is free."""
        self.names[name] = entity
        self.declared_at[name] = (file, position)
        self.library_names.discard(name)

    def replace(self, name: str) -> None:
        """Make a name of a library free for the project; the library itself keeps its own meaning."""
        self.library_names.discard(name)
        entity = self.find(name)
        self.names.pop(name, None)
        if entity is not None:
            self.shadowed[name] = entity
        self.types.pop(name, None)
        if name in self.pous:
            self.pous[f"{name}@library"] = self.pous.pop(name)
        if name in self.globals:
            self.globals[f"{name}@library"] = self.globals.pop(name)

    def where(self, name: str) -> str:
        """Return where a name was declared, for a message."""
        file, position = self.declared_at.get(name, ("", tree.NOWHERE))
        return f"in {file}, line {position.line}" if position.line else "in the control configuration"

    def values_of(self, kind: EnumType) -> dict[str, int]:
        """Return the numbers of an enumeration by their names."""
        work_out = self.enumerations.pop(kind, None)
        if work_out is not None:
            work_out()
        return kind.values

    def constant_of(self, variable: Variable) -> Value | None:
        """Return the value of a constant; None if it is not known because of a mistake."""
        start = self.starts.get(variable)
        if start is not None:
            self.compute(start)
        value = variable.initial
        if value is None and start is None:
            return start_of(variable.type)
        return value if not isinstance(value, list | dict) else None

    def has_start(self, variable: Variable) -> bool:
        """True if the declaration gives a start value, which is the default of an argument."""
        return variable in self.starts or variable.initial is not None

    def is_abstract(self, pou: Pou) -> bool:
        """True for a class or function block that has no instances, because methods of it have no code."""
        source = self.sources.get(pou)
        return source is not None and "ABSTRACT" in source.tree.modifiers

    def lacks_base(self, pou: Pou | None) -> bool:
        """True if the POU may have names that are not known, because a message says that what it extends is missing."""
        source = self.sources.get(pou) if pou is not None else None
        return source is not None and source.line is not None and source.line.is_broken

    def named_type(self, name: str) -> Type | None:
        """Return the type of this name: elementary, declared, a kind of object, or a function block."""
        wanted = self.key(name)
        pou = self.pous.get(wanted)
        return self.types.get(wanted) or (pou.type if pou is not None else None)
