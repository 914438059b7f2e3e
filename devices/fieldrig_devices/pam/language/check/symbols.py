"""The names of an application, and what a checker says about them."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.functions import Type
from fieldrig_devices.pam.language.items import Declaration, Parameter, Routine, Task
from fieldrig_devices.pam.language.items import Sequence as SequenceItem
from fieldrig_devices.pam.language.reserved import RESERVED
from fieldrig_devices.pam.language.tokens import mistake
from fieldrig_devices.pam.language.tree import Number, Place, Reference
from fieldrig_devices.pam.language.words import PREDECLARED

ITEMS_FROM: Final = ("NODE", "INC", "OBJECT")
"""Parameters whose object decides how many items an object has (PAML-080), in this order."""


@dataclass(frozen=True, slots=True)
class Symbol:
    name: str
    kind: str
    """The kind of the object, without INTERNAL or COMMON."""
    place: Place
    is_multiple: bool = False
    has_one_item: bool = False
    """True for an object whose NUMBER is 1, which is single (manual line 2666) and may have an index all the same."""
    declaration: Declaration | None = None
    routine: Routine | None = None


@dataclass(frozen=True, slots=True)
class Context:
    """The surroundings of a statement or expression."""

    is_multiple: bool = False
    """True where [i] is the present item."""
    is_reduced: bool = False
    """True inside parentheses with [all+] or [all*]."""
    where: str = "a sequence"
    allows_service: bool = True
    """True in sequences; actions and routines must not wait (PAML-260, PAML-272)."""
    formals: frozenset[str] = frozenset()
    routine: str = ""
    task: Task | None = None
    labels: frozenset[str] = frozenset()

    def reduced(self) -> "Context":
        return replace(self, is_reduced=True)


@dataclass(slots=True)
class Names:
    """The symbols that are declared up to now, and the messages."""

    symbols: dict[str, Symbol] = field(default_factory=dict)
    tasks: dict[str, Task] = field(default_factory=dict)
    mistakes: list[Mistake] = field(default_factory=list)
    defined: tuple[str, ...] = ()
    """The names of #define and #set."""

    def declare(self, symbol: Symbol) -> None:
        """Add a name.  A second one for the same name is reported."""
        known = self.symbols.get(symbol.name)
        if known is not None or symbol.name in PREDECLARED:
            line = f" in line {known.place.line}" if known is not None else " by the PAM"
            self.wrong(symbol.place, f"{symbol.name} is declared already{line}", "another name")
            return
        if symbol.name in RESERVED:
            self.wrong(symbol.place, f"{symbol.name} is a reserved word", "another name")
            return
        self.symbols[symbol.name] = symbol

    def object(self, reference: Reference) -> Symbol | None:
        """Return what a name stands for.  A name without an object is reported, and is None."""
        if reference.name in PREDECLARED:
            return Symbol(reference.name, PREDECLARED[reference.name], reference.place)
        symbol = self.symbols.get(reference.name)
        if symbol is None:
            self.wrong(
                reference.place, f"{reference.name} is not declared here", "an object", self._likely(reference.name)
            )
        return symbol

    def _likely(self, name: str) -> str:
        return self.likely(name, [*self.symbols, *self.defined]) or "An object is declared before it is used."

    @staticmethod
    def likely(name: str, known: Collection[str]) -> str:
        """Return the hint that a name is one of these, mistyped, or nothing."""
        from difflib import get_close_matches

        close = get_close_matches(name, known, 1, 0.75)
        return f"Perhaps {close[0]} is meant." if close else ""

    def wrong(self, place: Place, what: str, expected: str = "", hint: str = "") -> None:
        self.mistakes.append(mistake(place, what, expected, hint))

    def note(self, place: Place, what: str, hint: str = "") -> None:
        self.mistakes.append(mistake(place, what, "", hint, is_note=True))


def is_multiple(task: Task) -> bool:
    """True if a task has several items: by its SPECS, or because its sequences have [i] (manual line 3355)."""
    by_specs = any(parameter.name in ("NUMBER", "NODES_GROUP") and not _is_one(parameter) for parameter in task.specs)
    return by_specs or any(sequence.is_multiple for sequence in task.sequences)


def _is_one(parameter: Parameter) -> bool:
    value = parameter.values[0]
    return isinstance(value, Number) and value.value == 1


def is_port_input(symbol: Symbol) -> bool:
    """True for a variable that only the master writes."""
    kind = symbol.declaration.kind if symbol.declaration is not None else ""
    return "INPUT " in kind or kind.startswith("DUALPORT_IN ")


def is_port_output(symbol: Symbol) -> bool:
    kind = symbol.declaration.kind if symbol.declaration is not None else ""
    return kind.startswith(("VME OUTPUT", "RS422 OUTPUT", "DUALPORT_OUT"))


def sequence_of(task: Task, name: str) -> SequenceItem | None:
    return next((sequence for sequence in task.sequences if sequence.name == name), None)


def with_article(noun: str) -> str:
    """Return a noun with a or an in front of it."""
    is_spoken_with_vowel = noun[:1].upper() in "AEIO" or noun.startswith(("ST1", "LED_"))
    return f"{'an' if is_spoken_with_vowel else 'a'} {noun}"


def listed(words: Sequence[str]) -> str:
    """Return words as a message lists them: A, B or C."""
    return " or ".join(filter(None, [", ".join(words[:-1]), words[-1]])) if words else "nothing"


TYPE_NAMES: Final[Mapping[Type, str]] = {
    "flag": "a flag",
    "integer": "an integer",
    "real": "a number",
    "text": "a text",
}
