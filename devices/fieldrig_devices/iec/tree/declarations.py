"""Declarations of variables, types, POUs and configurations."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from fieldrig_devices.iec.tree.bodies import Body
from fieldrig_devices.iec.tree.expressions import Expression
from fieldrig_devices.iec.tree.nodes import NOWHERE, Position, Statement
from fieldrig_devices.iec.tree.types import Initial, TypeSpec, Variable

ACCESS: Final = frozenset({"PUBLIC", "PROTECTED", "PRIVATE", "INTERNAL"})
"""Words that say which code may use a variable, a method or a property (IEC 61131-3:2013, table 48)."""


class Section(Enum):
    LOCAL = "VAR"
    TEMP = "VAR_TEMP"
    STATIC = "VAR_STAT"
    INSTANCE = "VAR_INST"
    """Variables of a method that each instance has for itself."""
    GENERIC = "VAR_GENERIC"
    """Constants of a function block that each of its uses as a type gives."""
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
    access: str = ""
    """PUBLIC, PROTECTED, PRIVATE or INTERNAL behind VAR; empty for the default of its POU."""
    name: str = field(default="", compare=False)
    """The name of a list of global variables; programs of today's tools may write `name.variable`."""
    is_qualified: bool = field(default=False, compare=False)
    """True for a list with the attribute 'qualified_only', whose variables are known by `name.variable` only."""


@dataclass(slots=True)
class TypeDeclaration(Statement):
    name: str
    type: TypeSpec
    initial: Initial | None = None


class PouKind(Enum):
    PROGRAM = "PROGRAM"
    FUNCTION = "FUNCTION"
    FUNCTION_BLOCK = "FUNCTION_BLOCK"
    CLASS = "CLASS"

    @property
    def has_instances(self) -> bool:
        """True if variables can be of this type."""
        return self in (PouKind.FUNCTION_BLOCK, PouKind.CLASS)


@dataclass(slots=True)
class Action(Statement):
    name: str
    body: Body


@dataclass(slots=True)
class Method(Statement):
    """A method of a function block or program, with variables of its own for each call; or a part of a property."""

    name: str
    result: TypeSpec | None
    blocks: tuple[Variables, ...]
    body: Body
    modifiers: tuple[str, ...] = ()
    """Words such as PUBLIC, in capitals."""
    accessor: str = ""
    """GET or SET for a part of a property, whose type is then `result`; empty for a method."""


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
    modifiers: tuple[str, ...] = ()
    """Words such as ABSTRACT in front of the name, in capitals."""
    implements: tuple[str, ...] = ()
    """The interfaces whose methods a function block has."""
    end: Position = field(default=NOWHERE, compare=False, repr=False)
    extends_with: tuple[Expression, ...] = field(default=(), kw_only=True)
    """The generic constants behind EXTENDS, `EXTENDS Stack<10>`."""
    blocks_in_front: int = field(default=0, compare=False, repr=False, kw_only=True)
    """How many blocks with generic constants are in front of EXTENDS and IMPLEMENTS."""


@dataclass(slots=True)
class Interface(Statement):
    """Methods and properties that function blocks have in common, with empty bodies."""

    name: str
    extends: tuple[str, ...] = ()
    """Interfaces whose methods belong to this one too."""
    methods: tuple[Method, ...] = ()


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
    """CONFIGURATION ... END_CONFIGURATION with its one resource, or a RESOURCE without a configuration."""

    name: str
    blocks: tuple[Variables, ...] = ()
    tasks: tuple[TaskDeclaration, ...] = ()
    programs: tuple[ProgramInstance, ...] = ()
    resource: str = ""
    """The name of the resource; empty if the tasks belong to the configuration itself."""
    processor: str = ""
    """The name behind ON."""
    resources: "tuple[Configuration, ...]" = ()
    """The resources if there are several, without names of configurations; the fields above are not theirs then."""


class TestWord(Enum):
    """The blocks of a test file."""

    TEST = "TEST"
    SETUP = "SETUP"
    TEARDOWN = "TEARDOWN"


@dataclass(slots=True)
class RigUse(Statement):
    """`RIG 'feeder.yaml' AFTER T#10s`: the rig that tests run in, and the time that it takes to boot."""

    file: str
    delay: Expression | None = None
    """The time behind AFTER; `after` are comments, as everywhere."""


@dataclass(slots=True)
class Test(Statement):
    """`TEST 'name' VAR ... END_VAR statements END_TEST`, or a SETUP or TEARDOWN, which have no name."""

    word: TestWord
    name: str
    blocks: tuple[Variables, ...]
    body: Body
    rig: RigUse | None = None
    skip: str | None = None
    """Why the test does not run; None if it runs."""
    spelled: str = ""
    """TEST_PROGRAM or TEST_FUNCTION_BLOCK, with which files for truST begin a test; empty for TEST."""


@dataclass(slots=True)
class Use(Statement):
    """`USES 'pid.st';`: a file with code that the tests of this file judge."""

    file: str


Declaration = TypeDeclaration | Pou | Interface | Variables | Configuration


@dataclass(slots=True)
class Unit:
    """One source file.  `comments` are those behind its last declaration."""

    file: str
    declarations: tuple[Declaration, ...]
    comments: tuple[str, ...] = field(default=(), compare=False, repr=False)
    tests: tuple[Test, ...] = ()
    """Tests of programs, in the order of the text; a controller knows nothing of them."""
    uses: tuple[Use, ...] = ()
    rig: RigUse | None = None
    """The rig of all tests of the file that name none."""
