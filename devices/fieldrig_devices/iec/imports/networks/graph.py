"""The elements of a graphic body, as every exchange format has them, and the wires between them.

A wire belongs to its consumer and names the producer, as in PLCopen XML: values flow against the reference.
"""

from dataclasses import dataclass, field
from enum import Enum, auto


class Kind(Enum):
    SOURCE = "variable"
    SINK = "output variable"
    THROUGH = "in/out variable"
    BLOCK = "block"
    CONTACT = "contact"
    COIL = "coil"
    LEFT_RAIL = "left power rail"
    RIGHT_RAIL = "right power rail"
    LABEL = "label"
    JUMP = "jump"
    RETURN = "return"
    CONNECTOR = "connector"
    CONTINUATION = "continuation"
    COMMENT = "comment"
    TITLE = "network title"
    STEP = "step"
    TRANSITION = "transition"
    JUMP_STEP = "jump to a step"
    SELECTION_DIVERGENCE = "selection divergence"
    SELECTION_CONVERGENCE = "selection convergence"
    SIMULTANEOUS_DIVERGENCE = "simultaneous divergence"
    SIMULTANEOUS_CONVERGENCE = "simultaneous convergence"
    ACTIONS = "action block"


class Edge(Enum):
    NONE = auto()
    RISING = auto()
    FALLING = auto()


class Storage(Enum):
    NONE = auto()
    SET = auto()
    RESET = auto()


@dataclass(frozen=True, slots=True)
class Wire:
    """A reference to an output of another element; `pin` is empty for its only or first output."""

    source: str
    pin: str = ""


@dataclass(slots=True)
class Pin:
    name: str = ""
    line: int = 1
    wires: tuple[Wire, ...] = ()
    expression: str = ""
    """An operand that is written at the pin itself, instead of a wire."""
    is_negated: bool = False
    edge: Edge = Edge.NONE
    storage: Storage = Storage.NONE


@dataclass(slots=True)
class Drawn:
    """A body as a document has it: the text of ST or IL, the networks of LD or FBD, or the one chart of SFC."""

    language: str
    line: int
    text: str = ""
    networks: "list[Network]" = field(default_factory=list)
    is_divided: bool = False
    """True if the document itself divides the body into networks."""


@dataclass(slots=True)
class Use:
    """An action of an action block: a reference by name, or a body of its own."""

    line: int
    qualifier: str
    duration: str = ""
    name: str = ""
    body: Drawn | None = None


@dataclass(slots=True)
class Condition:
    """The condition of a transition: the name of a transition or variable, a wire, or a body of its own."""

    line: int
    name: str = ""
    pin: Pin | None = None
    body: Drawn | None = None
    is_negated: bool = False


@dataclass(slots=True)
class Item:
    """An element.  `text` is its operand, label, block type, or the name of a step."""

    kind: Kind
    id: str
    line: int
    text: str = ""
    instance: str = ""
    inputs: list[Pin] = field(default_factory=list)
    in_outs: list[Pin] = field(default_factory=list)
    outputs: list[Pin] = field(default_factory=list)
    is_negated: bool = False
    is_negated_behind: bool = False
    """The output side of an in/out variable."""
    edge: Edge = Edge.NONE
    storage: Storage = Storage.NONE
    order: int = 0
    """The order of execution that the author has set; 0 without."""
    x: float = 0.0
    y: float = 0.0
    is_statement: bool = False
    """True for a call of a program or action, which has no result."""
    code: str = ""
    """Structured Text inside of a block, on its line `code_line`."""
    code_line: int = 0
    # For charts:
    is_initial: bool = False
    priority: int | None = None
    condition: Condition | None = None
    uses: list[Use] = field(default_factory=list)
    phases: dict[str, str] = field(default_factory=dict)
    """Names of the actions for "entry", "active" and "exit" of a step."""

    def __str__(self) -> str:
        name = f" {self.instance or self.text}" if (self.instance or self.text) else ""
        return f"{self.kind.value}{name[:60]} (element {self.id})" if self.id else f"{self.kind.value}{name[:60]}"

    def pins(self) -> list[Pin]:
        """The inputs, and the variables that are passed through."""
        return [*self.inputs, *self.in_outs]


@dataclass(slots=True)
class Network:
    """Elements with unique identifiers.  `label` is a jump target in front of the network."""

    items: list[Item]
    label: str = ""
    line: int = 1
    comments: tuple[str, ...] = ()

    def by_id(self) -> dict[str, Item]:
        return {item.id: item for item in self.items}
