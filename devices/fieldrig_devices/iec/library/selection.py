"""The part of the libraries that a project uses.

Only that part is compiled, so a project pays for what it names, and its own names never disturb a block of a library
that it does not use.
"""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec.tree import (
    Declaration,
    EnumSpec,
    Interface,
    Pou,
    TypeDeclaration,
    Unit,
    Variable,
    Variables,
    walk,
)

_WORD: Final = re.compile(r"[A-Za-z_]\w*")
DRAWN: Final = frozenset({"r_trig", "f_trig"})
"""Blocks that drawn programs use without naming them, in contacts and coils for edges."""


def needed(libraries: Sequence[Unit], project: Sequence[Unit], texts: Iterable[str]) -> list[Unit]:
    """Return the libraries with those types and POUs that the texts of the project name, and what these need.

    A type or POU that the project declares takes the place of one of a library, and one of a later library that of an
    earlier one, so that a controller may have its own.  Of the constants only those that are named stay, of other
    global variables all.  A variable of a list with the attribute 'qualified_only' takes no place.
    """
    own = {name for name, _ in _named(map(_without_qualified, project))}
    known = {name: declared for name, declared in _named(libraries) if name not in own}
    known |= {value: declared for declared in known.values() for value in _values(declared) if value not in known}
    open_words = set(DRAWN)
    for text in texts:
        open_words.update(map(str.casefold, _WORD.findall(text)))
    for unit in libraries:
        open_words.update(word for declared in unit.declarations if _stays(declared) for word in words(declared))
    used: set[str] = set()
    while new := open_words & known.keys() - used:
        used |= new
        open_words = {word for name in new for word in words(known[name])}
    used |= {known[name].name.casefold() for name in used}
    return [replace(unit, declarations=tuple(_kept(unit.declarations, used, known))) for unit in libraries]


Named = Pou | Interface | TypeDeclaration | Variable


def _is_selected(block: Variables) -> bool:
    """True for constants, and for a list of variables with a name, of which only those that are named stay."""
    return block.is_constant or bool(block.name)


def _stays(declared: Declaration) -> bool:
    return isinstance(declared, Variables) and not _is_selected(declared)


def _without_qualified(unit: Unit) -> Unit:
    kept = (one for one in unit.declarations if not (isinstance(one, Variables) and one.is_qualified))
    return replace(unit, declarations=tuple(kept))


def _named(units: Iterable[Unit]) -> Iterator[tuple[str, Named]]:
    for unit in units:
        for declared in unit.declarations:
            if isinstance(declared, Pou | Interface | TypeDeclaration):
                yield declared.name.casefold(), declared
            elif isinstance(declared, Variables) and _is_selected(declared):
                yield from ((constant.name.casefold(), constant) for constant in declared.variables)


def _values(declared: Named) -> Iterator[str]:
    """Yield the values of an enumeration, by which a program may use it without its name."""
    if isinstance(declared, TypeDeclaration) and isinstance(declared.type, EnumSpec):
        yield from (value.name.casefold() for value in declared.type.values)


def _kept(declarations: Iterable[Declaration], used: set[str], known: Mapping[str, Named]) -> Iterator[Declaration]:
    def is_used(node: Named) -> bool:
        return node.name.casefold() in used and known[node.name.casefold()] is node

    for declared in declarations:
        if isinstance(declared, Variables) and _is_selected(declared):
            constants = tuple(filter(is_used, declared.variables))
            if constants:
                yield replace(declared, variables=constants)
        elif not isinstance(declared, Pou | Interface | TypeDeclaration) or is_used(declared):
            yield declared


def words(node: object) -> Iterator[str]:
    """Yield every word within a tree, without upper case."""
    for part in walk(node):
        if isinstance(part, str):
            yield from map(str.casefold, _WORD.findall(part))
