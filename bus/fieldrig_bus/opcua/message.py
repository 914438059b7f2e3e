"""Messages between an OPC UA server and the devices whose nodes it shows.

The server asks, and the device that a request names answers with the same `exchange`.  A device first makes an `Offer`;
a later one says that its nodes have changed.  Paths identify nodes within a device and are the identifiers of their
NodeIds.  Messages are never changed.
"""

from dataclasses import dataclass
from enum import Enum
from typing import Final

from fieldrig.device import Value
from fieldrig.faults.note import FaultNote

LONGEST_PATH: Final = 4096
"""Longest path, name or unit, in characters; a NodeId has no more (OPC 10000-3, 8.2.4)."""
LONGEST_TEXT: Final = 4096
MOST_NODES: Final = 100
"""Nodes in one answer; the server asks for the rest."""
MOST_PATHS: Final = 200
"""Paths in one Read."""
MOST_ELEMENTS: Final = 10_000
"""Elements of an array that is read or written as a whole."""

MOST_ARGUMENTS: Final = 20
"""Arguments, or results, of a method."""
NODE: Final = "NODE"
"""The type of an argument that names a node of the device; its value is the path."""
VALUE: Final = "VALUE"
"""The type of an argument that is a value of the node that the argument before it names."""

AnyValue = Value | list[Value]


class Kind(Enum):
    OBJECT = "object"
    VARIABLE = "variable"
    METHOD = "method"


class Status(Enum):
    GOOD = "good"
    UNKNOWN = "unknown"
    """There is no such node."""
    NOT_WRITABLE = "not writable"
    TYPE_MISMATCH = "type mismatch"
    OUT_OF_RANGE = "out of range"
    REFUSED = "refused"
    """Not possible in the present state."""
    NOT_SUPPORTED = "not supported"
    """Not possible for this node."""
    WRONG_ARGUMENTS = "wrong arguments"
    """Arguments of a method are not accepted, each with a status of its own."""
    TOO_LARGE = "too large"
    """A value is larger than a message can be."""
    BAD = "bad"
    SENSOR_FAILURE = "sensor failure"
    DEVICE_FAILURE = "device failure"
    NO_ANSWER = "no answer"
    """The device does not answer; only the server uses it."""


@dataclass(frozen=True, slots=True)
class Argument:
    """An argument or a result of a method."""

    name: str
    type: str
    """An IEC 61131-3 type, NODE or VALUE."""
    about: str = ""
    is_array: bool = False


@dataclass(frozen=True, slots=True)
class Node:
    """One node as a client sees it; `parent` is a path, empty for the device itself."""

    path: str
    parent: str
    name: str
    kind: Kind = Kind.VARIABLE
    type: str = ""
    """IEC 61131-3 type of a variable, or of the elements of an array, such as DINT; empty otherwise."""
    length: int | None = None
    """Number of elements of an array; None for a single value."""
    is_writable: bool = False
    """True for a variable that can be written, and for a method that changes something."""
    has_children: bool = False
    unit: str = ""
    about: str = ""
    low: float | None = None
    high: float | None = None
    """The range of the value, if it is narrower than that of the type."""
    choices: tuple[tuple[str, int], ...] = ()
    """The values of an enumeration."""
    arguments: tuple[Argument, ...] = ()
    results: tuple[Argument, ...] = ()
    """Arguments and results of a method."""


@dataclass(frozen=True, slots=True)
class Offer:
    device: str
    about: str
    generation: int
    """Counts the changes of the nodes."""


@dataclass(frozen=True, slots=True)
class Browse:
    """Asks for children from number `first` on, in order; of the device itself if the path is empty."""

    device: str
    exchange: int
    path: str
    first: int = 0


@dataclass(frozen=True, slots=True)
class Find:
    device: str
    exchange: int
    path: str


@dataclass(frozen=True, slots=True)
class Read:
    device: str
    exchange: int
    paths: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Write:
    device: str
    exchange: int
    path: str
    value: AnyValue


@dataclass(frozen=True, slots=True)
class Call:
    device: str
    exchange: int
    path: str
    arguments: tuple[AnyValue, ...] = ()


@dataclass(frozen=True, slots=True)
class Nodes:
    """The answer to Browse, and to Find (one node or none)."""

    exchange: int
    nodes: tuple[Node, ...]
    is_complete: bool = True


@dataclass(frozen=True, slots=True)
class Outcome:
    status: Status
    value: AnyValue | None = None
    text: str = ""
    results: tuple[AnyValue, ...] = ()
    """The results of a method."""
    arguments: tuple[Status, ...] = ()
    """A status for each argument, if the status of the whole is WRONG_ARGUMENTS."""


@dataclass(frozen=True, slots=True)
class Outcomes:
    """The answer to Read, with an outcome for each of the first paths, and to Write and Call, with one."""

    exchange: int
    outcomes: tuple[Outcome, ...]


@dataclass(frozen=True, slots=True)
class Hangup:
    """Tells the server to close the connections of all clients, because of an injected fault."""


Request = Browse | Find | Read | Write | Call
Answer = Nodes | Outcomes
OpcUaMessage = Offer | Request | Answer
"""Every message that an OPC UA bus carries."""
OnOpcUa = OpcUaMessage | Hangup | FaultNote
"""The same, and those that only the server and the trace get."""
REQUESTS: Final = (Browse, Find, Read, Write, Call)
ANSWERS: Final = (Nodes, Outcomes)
