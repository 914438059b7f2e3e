"""The surroundings of an expression or statement: its POU, its file, and what names mean there."""

from collections import ChainMap
from collections.abc import Iterable, Mapping, MutableMapping
from itertools import chain
from typing import Final, NamedTuple

from fieldrig_devices.iec.check.extension import Extension
from fieldrig_devices.iec.check.project import Entity, PouSource, Project
from fieldrig_devices.iec.library import intrinsics
from fieldrig_devices.iec.program import Expression, Pou, Space, Variable
from fieldrig_devices.iec.tree import Binary, Call, Node, Position, PouKind, Section
from fieldrig_devices.iec.types import Type
from fieldrig_devices.languages.mistakes import Code

_KNOWN_ELSEWHERE: Final[Mapping[str, str]] = {
    "break": "EXIT leaves a loop, and a branch of CASE ends by itself",
    "default": "the last branch of CASE begins with ELSE",
    "null": "the address of nothing is 0",
    "pacdrivem": "it is the MAx-4: `fieldrig iec check FILE --rig RIG` knows the objects and libraries of a controller",
    "print": "`fieldrig iec run` shows the variables",
    "printf": "`fieldrig iec run` shows the variables",
}
"""Words of other languages that a beginner may write, and the object of every MAx-4, with what to do instead."""
OUTSIDE: Final = "."
"""In front of a name, it stands for a library or a namespace: the name means nothing that the POU declares itself."""


def position_of(node: Node) -> Position:
    """Return the position that a message points to; for a call it is what is called, not the bracket."""
    return node.called.position if isinstance(node, Call) else node.position


class Checked(NamedTuple):
    """An operation that was checked, with what keeps its identities."""

    node: Binary
    wanted: Type | None
    value: Expression | None


class Context:
    def __init__(
        self, project: Project, source: PouSource | None, file: str, pou: Pou | None = None, level: int = 0
    ) -> None:
        self.project, self.source, self.file = project, source, file
        self.key = project.key
        self.pou = pou if pou is not None else source.pou if source is not None else None
        """The POU or action whose body is checked."""
        self.names: MutableMapping[str, Variable] = source.names if source is not None else {}
        if source is not None and source.outer is not None:
            self.names = ChainMap(source.names, source.outer.names)
        self.is_library = source is not None and source.is_library
        self.mixes_integers = project.dialect.mixes_integers or self.is_library
        """True if integers and bit strings go into one another; libraries are written for EPAS-4."""
        self.computes_in_32_bits = project.dialect.computes_in_32_bits or self.is_library
        self.level = max(level, source.level if source is not None else 0)
        """How many steps above the function block the code was declared that is checked; SUPER^ is above it."""
        self.listed: Mapping[str, str] = {}
        """The names of the list of global variables that is declared, with those by which the project knows them."""
        self.operations: dict[tuple[int, int], Checked] | None = None
        """Operations by the identities of their trees and of the types that were wanted; None outside of an operation
        whose operands may be checked twice."""
        self._unknown: set[str] = set()
        self._hidden = 0

    @property
    def extension(self) -> Extension | None:
        """The extension that adds statements to the code that is checked; None for code that is no test."""
        extension = self.project.extension
        return extension if extension is not None and extension.applies(self.file) else None

    @property
    def owner(self) -> Pou | None:
        """The POU; for an action, the one that it belongs to."""
        return self.source.pou if self.source is not None else None

    @property
    def block(self) -> Pou | None:
        """The function block or program whose instance the code works with; that of a method is its owner."""
        return self.owner.owner or self.owner if self.owner is not None else None

    def find(self, name: str) -> Entity | None:
        wanted = self.key(name)
        entity: Entity | None = self.names.get(wanted)
        if entity is not None and self.is_temporary_of_block(wanted):
            entity = None
        if entity is None and self.is_library:
            entity = self.project.shadowed.get(wanted)
        return entity or self.project.find(self.listed.get(wanted, wanted).removeprefix(OUTSIDE))

    def is_temporary_of_block(self, wanted: str) -> bool:
        """True in a method for a VAR_TEMP of its function block, which exists only while the body of that runs."""
        source = self.source
        if source is None or source.outer is None or wanted in source.names:
            return False
        known = source.outer.names.get(wanted)
        return known is not None and known.section is Section.TEMP

    def say(
        self,
        node: Node,
        what: str,
        expected: str = "",
        hint: str = "",
        code: Code = Code.OTHER,
        name: str = "",
    ) -> None:
        self.project.reports.say(self.file, position_of(node), what, expected, hint, code, name)

    def note(self, node: Node, what: str, hint: str = "") -> None:
        self.project.reports.note(self.file, position_of(node), what, hint)

    def is_type(self, name: str) -> bool:
        """Return whether this is the name of a type: elementary, STRING and WSTRING, or declared."""
        return name.upper() in ("STRING", "WSTRING") or self.project.named_type(name) is not None

    def say_unknown(self, node: Node, name: str, expected: str = "", others: Iterable[str] = ()) -> None:
        """Report an unknown name, once in each body; `others` are words that may have been meant besides names."""
        if not name or name[0].isdigit():  # the parser has reported it
            return
        if self.key(name) in self._unknown or self.project.lacks_base(self.block):
            return  # the parser has reported an empty name, and a message about EXTENDS is enough
        self._unknown.add(self.key(name))
        if self.key(name) in self.project.names:
            self.say(node, f"{name} is defined by itself", "a constant")
            return
        if self.is_type(name):
            self.say(node, f"{name} is a type", expected or "a value", f"x : {name}; declares a variable of it")
            return
        if intrinsics.is_standard(name):
            self.say(node, f"{name} is a FUNCTION", expected or "a value", f"{name}(...) calls it")
            return
        if self.is_temporary_of_block(self.key(name)):
            assert self.block is not None
            what = f"{name} is a VAR_TEMP of {self.block.name}, whose body alone knows it"
            self.say(node, what, "a variable of VAR", f"give the method {name} as a VAR_INPUT")
            return
        entities = chain(self.names.items(), self.project.names.items())
        known = (getattr(entity, "name", name) for name, entity in entities)
        hint = _KNOWN_ELSEWHERE.get(name.casefold()) or self.project.reports.closest(name, chain(known, others))
        if name.startswith("_") and not hint:
            hint = (
                f"{name} is the logical address of the object {name[1:]}, which the control configuration does not have"
            )
        self.say(node, f"{name} is not declared", expected or ("" if hint else "a name from a declaration"), hint)

    def hidden(self, name: str, kind: Type, space: Space | None = None) -> Variable:
        """Make a variable that the source doesn't show; `name` only says what it is for.

        In a function it is on the stack; elsewhere it belongs to the instance, unless `space` says otherwise.
        """
        assert self.source is not None
        owner = self.source.pou
        if space is None:
            space = Space.FRAME if owner.kind is PouKind.FUNCTION else Space.INSTANCE
        section = Section.TEMP if space is Space.FRAME else Section.LOCAL
        number = len(owner.variables)
        variable = Variable(f"${name}{number}", kind, space, section, file=self.file)
        owner.variables[self.key(variable.name)] = variable
        return variable
