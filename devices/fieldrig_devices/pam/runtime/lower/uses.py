"""The ways in which generated code uses objects: each is a function of its own, which is made when a program starts."""

from dataclasses import dataclass, field
from enum import Enum
from typing import Final

from fieldrig_devices.pam.language.tree import Index


class Verb(Enum):
    """The work of a function.  The value is the beginning of the function's name in the generated text."""

    VALUE = "value"
    """Return the value of an item."""
    SET = "give"
    """Give an item a value."""
    ASK = "ask"
    """Ask an item."""
    POLL = "poll"
    """Ask an item whose answer may be pending, in a condition: without an answer the condition does not hold yet."""
    NOW = "now"
    """Ask an item whose answer may be pending, where nothing can wait: without an answer the last one counts."""
    LATER = "later"
    """Ask an item whose answer may be pending, in a sequence: True if the sequence has to wait."""
    DO = "do"
    """Let an item carry out a function."""
    GET = "get"
    """Return a parameter."""
    PUT = "set"
    """Give a parameter a value."""
    CONNECT = "connect"
    """Make a pipe."""
    ANY = "any"
    """Return the OR of a formula over all items that are active."""
    ALL = "all"
    """Return the AND of a formula over all items that are active."""


@dataclass(frozen=True, slots=True)
class Fixed:
    """An argument that is a symbolic word or a text."""

    value: str


@dataclass(frozen=True, slots=True)
class ItemOf:
    """An argument that is an object."""

    name: str
    index: Index | None


Argument = Fixed | ItemOf | None
"""None is a value that generated code computes."""


@dataclass(frozen=True, slots=True)
class Use:
    verb: Verb
    name: str
    """The object, or the task or equation whose items are joined."""
    index: Index | None = None
    word: str = ""
    """The function, the parameter, or the formula."""
    arguments: tuple[Argument, ...] = ()
    routine: str | None = None
    """The routine that a parameter gets, with the computed arguments; NONE is empty."""


@dataclass(slots=True)
class Uses:
    """The uses of an application by the names of their functions."""

    table: dict[str, Use] = field(default_factory=dict)
    _names: dict[Use, str] = field(default_factory=dict)

    def name(self, use: Use) -> str:
        known = self._names.get(use)
        if known is None:
            known = self._names[use] = f"{use.verb.value}_{len(self._names)}"
            self.table[known] = use
        return known


PENDING: Final = frozenset(
    {("ENCODER", "value"), ("ENCODER", "position"), ("ENCODER", "speed"), ("DC_MOTOR", "position")}
)
"""Inquiries whose answers may have to come over the ring, by the kind of the object (PAML-144)."""
