"""The contract between the programs of an application and its objects.

Names of parameters, functions and symbolic values are those of the tables in `language/objects.py` and
`language/functions.py`.  The checker has refused everything else, so neither side checks names again.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Protocol

Value = bool | int | float
"""A flag, an integer of 32 bits with a sign, or a real (PAML-221 to PAML-223)."""


class Pending:
    """An answer that is under way on the ring; the sequence that asked is suspended until then (PAML-144)."""

    __slots__ = ("value",)

    def __init__(self) -> None:
        self.value: Value | None = None
        """The answer, or None as long as it is not there."""


@dataclass(frozen=True, slots=True)
class RoutineRef:
    """A routine with its arguments, as a block starts it; a comparator's NONE has an empty name."""

    routine: str
    arguments: tuple[Any, ...] = ()
    """Values, and items of objects."""


class Item(Protocol):
    """One item of an object.  An object with NUMBER or a NODES_GROUP has several, numbered from 0."""

    def value(self) -> Value | Pending:
        """Return what the object's name stands for in an expression.  Only an encoder's may be pending."""

    def set_value(self, value: Value) -> None:
        """Carry out `object <- value`.

        The value is a flag for a binary object, an integer of 32 bits for a digital or analog output of a node, and a
        number as it was computed for any other object.
        """

    def ask(self, function: str, arguments: Sequence[Any]) -> Value | Pending:
        """Answer `object ? function(arguments)`."""

    def do(self, function: str, arguments: Sequence[Any]) -> None:
        """Carry out `object <- function(arguments)`.  Arguments are values, symbolic words, texts and items."""

    def parameter(self, name: str) -> Value:
        """Return `object:NAME`."""

    def set_parameter(self, name: str, value: "Value | str | RoutineRef | Item") -> None:
        """Carry out `object:NAME <- value`.  A value that the manual says is ignored is ignored."""


class Kernel(Protocol):
    """The services of the run time for objects."""

    @property
    def thirds(self) -> int:
        """BASIC_PAM_CYCLE in thirds of a millisecond."""

    @property
    def cycle_number(self) -> int:
        """Number of basic cycles since power-on."""

    def touched(self, name: str) -> None:
        """The value of the object changed, or an answer of one of its inquiries: what waits for it is looked at.

        It is needed for values and for answers that are flags or integers.  What waits for an answer or a parameter
        that is a real looks at it in each of its cycles (G-19), so that a moving axis causes no calls.
        """

    def start_routine(self, routine: RoutineRef) -> None:
        """Run a routine between the pipes and the ring of this basic cycle (G-16)."""

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        """Show a system message of section 14, such as `07..E021`, with its details."""


class Part(Protocol):
    """A part of the PAM that has objects of the application: the machine's objects, a port, or the panel."""

    @property
    def items(self) -> Mapping[str, Sequence[Item]]:
        """The items of each object, by its name."""

    def take(self) -> None:
        """Begin a basic cycle: what the ring has brought has been reported, and answers are there."""

    def give(self) -> None:
        """Hand the set-points and orders of this basic cycle to the ring."""


class Objects(Part, Protocol):
    """All objects of an application that are not of the language itself: the run time has variables and BOOLEANs."""

    def is_active(self, name: str, index: int) -> bool:
        """Return False if the item of an object, or of a NODES_GROUP, belongs to a component that is missing (G-46)."""

    def connect(self, blocks: Sequence[Item]) -> None:
        """Make and activate a pipe, from the output block to the input block (PAML-403)."""

    def flow(self) -> None:
        """Let all pipes that are due in this basic cycle flow."""
