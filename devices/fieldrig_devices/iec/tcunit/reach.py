"""The units of a project, and those of them that its suites reach.

A project has up to some hundred units, of which its suites use a few.  Only these are parsed, checked and compiled, so
that a unit that needs a machine, or a library that is not there, stops no suite but those that use it.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig.text.nearest import closest
from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import CODESYS
from fieldrig_devices.iec.imports import read_source
from fieldrig_devices.iec.imports.event_classes import TAKES_TEXTS
from fieldrig_devices.iec.library.selection import words as words_of
from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.languages.source_file import SourceFile

_WORD: Final = re.compile(r"[A-Za-z_]\w*")
_OBJECT: Final = re.compile(r"<(?:POU|Itf)\s[^>]*?Name=\"([^\"]*)\"")
_CODE: Final = re.compile(r"<!\[CDATA\[(.*?)\]\]>", re.DOTALL)
_COMMENT: Final = re.compile(r"\(\*.*?\*\)|//[^\n]*", re.DOTALL)
RUN: Final = frozenset({"run", "run_in_sequence"})
"""The functions of TcUnit that a program calls in each cycle, in small letters."""
SUITE: Final = "fb_testsuite"


@dataclass(slots=True, eq=False)
class Item:
    """A POU, an interface, a type, or one global variable, with the words in it."""

    name: str
    """In small letters."""
    file: str
    line: int
    declaration: tree.Declaration
    is_ours: bool
    """False for an item of a library that the project names."""
    words: frozenset[str]
    other_names: frozenset[str] = frozenset()
    """The values of an enumeration, by which it may be used without its name."""

    @property
    def title(self) -> str:
        return getattr(self.declaration, "name", "") or self.name


@dataclass(slots=True)
class Units:
    """The files of a project and of its libraries; each is read when something in it is first named."""

    mistakes: dict[str, list[Mistake]] = field(default_factory=dict)
    """The mistakes in each file that was read."""
    by_name: dict[str, list[Item]] = field(default_factory=dict)
    tasks: list[tree.Configuration] = field(default_factory=list)
    doubles: list[tuple[Item, Item]] = field(default_factory=list)
    """The POUs of the project whose name another one has, each behind that one; nothing reaches them."""
    lists: dict[str, list[str]] = field(default_factory=dict)
    """The variables of the lists of global variables, by the names of these in small letters."""
    _later: dict[str, list[tuple[SourceFile, bool]]] = field(default_factory=dict)
    """The files with one POU or interface that have not been read, by its name."""
    _words: dict[str, frozenset[str]] = field(default_factory=dict)

    def add(self, files: Sequence[SourceFile], *, is_ours: bool) -> None:
        for file in files:
            named = _OBJECT.search(file.text[:2_000])
            if named is not None:
                self._later.setdefault(named[1].casefold(), []).append((file, is_ours))
            else:
                self._read(file, is_ours)

    def named(self, name: str) -> Sequence[Item]:
        """Return the items that a word may mean."""
        for file, is_ours in self._later.pop(name, ()):
            self._read(file, is_ours)
        return self.by_name.get(name, ())

    def texts_with(self, words: Iterable[str]) -> list[str]:
        """Return the names of the POUs and interfaces that have not been read and have one of these words."""
        wanted = frozenset(words)
        return [
            name
            for name, waiting in self._later.items()
            if any(self._words_in(file) & wanted for file, is_ours in waiting if is_ours)
        ]

    def _words_in(self, file: SourceFile) -> frozenset[str]:
        if file.name not in self._words:
            code = "\n".join(_CODE.findall(file.text)) or file.text
            self._words[file.name] = frozenset(map(str.casefold, _WORD.findall(_COMMENT.sub(" ", code))))
        return self._words[file.name]

    def _read(self, file: SourceFile, is_ours: bool) -> None:
        unit, mistakes = read_source(file.name, file.text, CODESYS)
        self.mistakes[file.name] = mistakes
        parts = list(_parts(unit))
        for declaration, name in parts:
            if isinstance(declaration, tree.Configuration):
                self.tasks += [declaration] if is_ours else []
                continue
            if isinstance(declaration, tree.Variables) and declaration.name:
                self.lists.setdefault(declaration.name.casefold(), []).append(declaration.variables[0].name)
            words = self._words_in(file) if len(parts) == 1 else frozenset(words_of(declaration))
            line = declaration.position.line
            item = Item(name, file.name, line, declaration, is_ours, words, _values(declaration))
            first = next((one for one in self.by_name.get(name, ()) if is_ours and _are_pous(one, item)), None)
            if first is not None:
                self.doubles.append((first, item))
                continue
            for key in (item.name, *item.other_names):
                known = self.by_name.setdefault(key, [])
                if is_ours:
                    known.insert(0, item)
                elif not any(other.name == item.name and other.is_ours for other in known):
                    known.append(item)


def _are_pous(one: Item, other: Item) -> bool:
    """True for two POUs of the project."""
    return one.is_ours and isinstance(one.declaration, tree.Pou) and isinstance(other.declaration, tree.Pou)


def _parts(unit: tree.Unit) -> Iterator[tuple[tree.Declaration, str]]:
    """Yield the declarations of a unit, those of global variables one by one, each with its name in small letters."""
    for declaration in unit.declarations:
        if isinstance(declaration, tree.Variables):
            for variable in declaration.variables:
                part = replace(declaration, variables=(variable,))
                part.position = variable.position
                yield part, variable.name.casefold()
        else:
            yield declaration, declaration.name.casefold()


def _values(declaration: tree.Declaration) -> frozenset[str]:
    if isinstance(declaration, tree.TypeDeclaration) and isinstance(declaration.type, tree.EnumSpec):
        return frozenset(value.name.casefold() for value in declaration.type.values)
    return frozenset()


_COMPANIONS: Final = dict.fromkeys(("tc_events", "tc_event_classes"), frozenset({TAKES_TEXTS.casefold()}))
"""Variables that those of these names need, though they do not name them."""


def closure(
    units: Units, roots: Iterable[Item], without: Iterable[Item] = (), changed: Mapping[Item, Item] | None = None
) -> list[Item]:
    """Return the items that these reach, with themselves, in the order in which they are found.

    `changed` has what is taken instead of an item.
    """
    found: dict[Item, None] = {}
    left_out, waiting = set(without), list(roots)
    while waiting:
        item = waiting.pop(0)
        if item in left_out:
            continue
        item = (changed or {}).get(item, item)
        if item in found:
            continue
        found[item] = None
        for word in sorted(item.words | _COMPANIONS.get(item.name, frozenset())):
            waiting += [other for other in units.named(word) if other not in found]
    return list(found)


def is_suite(units: Units, item: Item) -> bool:
    """True for a function block that extends FB_TestSuite, at whatever distance."""
    seen: set[str] = set()
    above: tree.Declaration | None = item.declaration
    while isinstance(above, tree.Pou) and above.extends:
        name = above.extends.rpartition(".")[2].casefold()
        if name == SUITE:
            return True
        if name in seen:
            return False
        seen.add(name)
        above = next((one.declaration for one in units.named(name) if isinstance(one.declaration, tree.Pou)), None)
    return False


def calls_run(declaration: tree.Declaration) -> frozenset[str]:
    """Return the names of RUN and RUN_IN_SEQUENCE that a POU calls, in small letters."""
    if not isinstance(declaration, tree.Pou):
        return frozenset()
    return frozenset(_runs(declaration))


def _runs(declaration: tree.Pou) -> Iterator[str]:
    for node in tree.walk(declaration):
        if isinstance(node, tree.Call):
            called = node.called
            name = called.text if isinstance(called, tree.Name) else getattr(called, "name", "")
            owner = getattr(called, "of", None)
            is_of_library = owner is None or (isinstance(owner, tree.Name) and owner.text.casefold() == "tcunit")
            if name.casefold() in RUN and is_of_library:
                yield name.casefold()


def about_list(units: Units, item: Item, mistake: Mistake) -> Mistake:
    """Return a mistake about a list that has none of the variables that are reached as one about its variable."""
    name = mistake.what.removesuffix(" is not declared")
    variables = units.lists.get(name.casefold())
    if variables is None or name == mistake.what:
        return mistake
    lacking = [
        part.name
        for part in tree.walk(item.declaration)
        if isinstance(part, tree.Member) and isinstance(part.of, tree.Name) and part.position.line == mistake.line
        if part.of.text.casefold() == name.casefold() and part.name.casefold() not in map(str.casefold, variables)
    ]
    if not lacking:
        return mistake
    what = f"the list {name} has no variable {lacking[0]}"
    return replace(mistake, what=what, expected="", hint=closest(lacking[0], variables))


def place_of(items: Sequence[Item], mistake: Mistake) -> Item | None:
    """Return the item that a mistake is in: the last one that begins in front of it."""
    inside = [item for item in items if item.file == mistake.file]
    before = [item for item in inside if item.line <= mistake.line]
    return max(before, key=lambda item: item.line, default=inside[0] if inside else None)


def as_units(items: Iterable[Item], order: Mapping[str, int]) -> list[tree.Unit]:
    """Return the items as units of their files; the variables of one list are one block again."""
    by_file: dict[str, list[Item]] = {}
    for item in items:
        by_file.setdefault(item.file, []).append(item)
    made = []
    for file in sorted(by_file, key=lambda name: order.get(name, len(order))):
        declarations: list[tree.Declaration] = []
        for item in sorted(by_file[file], key=lambda one: one.line):
            last, part = declarations[-1] if declarations else None, item.declaration
            if isinstance(part, tree.Variables) and isinstance(last, tree.Variables) and _is_same_block(last, part):
                declarations[-1] = joined = replace(last, variables=(*last.variables, *part.variables))
                joined.name = part.name
            else:
                declarations.append(part)
        made.append(tree.Unit(file, tuple(declarations)))
    return made


def _is_same_block(one: tree.Variables, other: tree.Variables) -> bool:
    return replace(one, variables=()) == replace(other, variables=()) and one.name == other.name
