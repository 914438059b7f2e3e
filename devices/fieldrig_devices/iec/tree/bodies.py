"""Bodies in the languages besides Structured Text: Instruction List and Sequential Function Charts."""

from dataclasses import dataclass

from fieldrig_devices.iec.tree.expressions import Expression
from fieldrig_devices.iec.tree.nodes import Node, Statement
from fieldrig_devices.iec.tree.statements import AnyStatement

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
    """An action at a step: `name(qualifier, time, indicator)`.  `qualifier` is one of N R S L D P SD DS SL P0 P1."""

    name: str
    qualifier: str = "N"
    time: Expression | None = None
    indicators: tuple[str, ...] = ()
    """Variables that show what the action does; they only document it."""


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
