"""Instances of programs: in edition 3 of the standard, each PROGRAM of a configuration has its own variables.

`PROGRAM first WITH fast : Count; PROGRAM second WITH slow : Count;` makes a copy of Count with the name `second`; the
first instance is the program Count itself, so that `Count.n` means what it means with one instance.
"""

from collections.abc import Collection, Iterator, Sequence
from copy import deepcopy
from dataclasses import replace

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect


def separated(units: Sequence[tree.Unit], dialect: Dialect) -> Sequence[tree.Unit]:
    """Return the units with a program for each further instance, unless its name is taken."""
    if not dialect.has_program_instances:
        return units
    declared = [one for unit in units for one in unit.declarations]
    names = {dialect.key(name) for one in declared for name in _names(one)}
    programs = {dialect.key(one.name): one for one in declared if _is_program(one)}
    firsts: dict[str, str] = {}
    copies: dict[str, tuple[tree.Declaration, tree.Declaration]] = {}
    """Programs with their copies, by the names of these."""
    for instance in _instances(units):
        name, kind = dialect.key(instance.name), dialect.key(instance.type)
        program = programs.get(kind)
        if isinstance(program, tree.Pou) and firsts.setdefault(kind, name) != name and name not in names:
            copy = deepcopy(program)
            copy.name = instance.name
            copies[name] = program, copy
    if not copies:
        return units
    made = []
    for unit in units:
        declarations = [_renamed(one, copies, firsts, dialect) for one in unit.declarations]
        declarations += [copy for program, copy in copies.values() if any(one is program for one in unit.declarations)]
        made.append(replace(unit, declarations=tuple(declarations)))
    return made


def _is_program(declaration: tree.Declaration) -> bool:
    return isinstance(declaration, tree.Pou) and declaration.kind is tree.PouKind.PROGRAM


def _names(declaration: tree.Declaration) -> Iterator[str]:
    """Yield the names that a declaration gives to units and global variables."""
    if isinstance(declaration, tree.Configuration):
        for block in declaration.blocks:
            yield from _names(block)
        for resource in declaration.resources:
            yield from _names(resource)
    elif isinstance(declaration, tree.Variables):
        yield from (one.name for one in declaration.variables)
    else:
        yield declaration.name


def _instances(units: Sequence[tree.Unit]) -> Iterator[tree.ProgramInstance]:
    for unit in units:
        for one in unit.declarations:
            if isinstance(one, tree.Configuration):
                yield from one.programs
                for resource in one.resources:
                    yield from resource.programs


def _renamed(
    declaration: tree.Declaration, copies: Collection[str], firsts: dict[str, str], dialect: Dialect
) -> tree.Declaration:
    """Return a configuration whose instances have the copies as their types."""
    if not isinstance(declaration, tree.Configuration):
        return declaration
    programs = tuple(
        replace(one, type=one.name)
        if dialect.key(one.name) in copies and firsts.get(dialect.key(one.type)) != dialect.key(one.name)
        else one
        for one in declaration.programs
    )
    resources = tuple(_renamed(one, copies, firsts, dialect) for one in declaration.resources)
    return replace(declaration, programs=programs, resources=resources)  # type: ignore[arg-type]
