"""The items of a PAM application: its header, the declarations of objects, and the programs."""

from dataclasses import dataclass
from typing import Literal

from fieldrig_devices.pam.language.tree import Expression, Node, Reference, RoutineCall, SequenceRef, Statement


@dataclass(frozen=True, slots=True)
class Parameter(Node):
    name: str
    values: tuple[Expression | RoutineCall, ...] = ()


@dataclass(frozen=True, slots=True)
class Declaration(Node):
    """An object of a kind that is described by its parameters."""

    kind: str
    name: str
    parameters: tuple[Parameter, ...] = ()
    parts: tuple["Declaration", ...] = ()
    """The traces of a multi-comparator, and the variables of a DualPort."""


@dataclass(frozen=True, slots=True)
class BooleanEquation(Node):
    name: str
    is_multiple: bool
    linked_output: Reference | None
    equation: Expression


@dataclass(frozen=True, slots=True)
class Reaction(Node):
    """An action: what is done at each event, or as long as a state is true."""

    trigger: Literal["ON_EVENT", "ON_STATE"]
    condition: Expression
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Actions(Node):
    name: str
    specs: tuple[Parameter, ...]
    reactions: tuple[Reaction, ...]
    power_on: tuple[Statement, ...] | None = None


@dataclass(frozen=True, slots=True)
class Routine(Node):
    name: str
    formals: tuple[str, ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Routines(Node):
    name: str
    routines: tuple[Routine, ...]
    power_on: tuple[Statement, ...] | None = None


@dataclass(frozen=True, slots=True)
class Event(Node):
    condition: Expression
    sequence: SequenceRef


@dataclass(frozen=True, slots=True)
class Sequence(Node):
    name: str
    is_multiple: bool
    specs: tuple[Parameter, ...]
    body: tuple[Statement, ...]


@dataclass(frozen=True, slots=True)
class Task(Node):
    name: str
    specs: tuple[Parameter, ...]
    events: tuple[Event, ...]
    sequences: tuple[Sequence, ...]
    power_on: tuple[Statement, ...] | None = None


@dataclass(frozen=True, slots=True)
class Application(Node):
    """The header: NAME with a version, BASIC_PAM_CYCLE in thirds of a millisecond, DEFAULT_TASK_WORKSPACE in bytes."""

    name: str
    version: str
    parameters: tuple[Parameter, ...]


Item = Application | Declaration | BooleanEquation | Actions | Routines | Task


@dataclass(frozen=True, slots=True)
class Program:
    items: tuple[Item, ...]
    defined: tuple[str, ...] = ()
    """The names of #define and #set, for the message about one that is mistyped."""
