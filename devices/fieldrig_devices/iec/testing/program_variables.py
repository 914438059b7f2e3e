"""Variables of tests that have a program as their type: `VAR uut : Conveyor; END_VAR`, as files for STruC++ have them.

A program exists once in the language, and each test begins with fresh variables.  So the first variable of a program
stands for the program itself, with its tasks and addresses; each further one in the same test stands for a copy.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from copy import deepcopy
from dataclasses import replace

from fieldrig_devices.iec import tree


class ProgramVariables:
    """The programs of a project, and the copies of them that tests need."""

    def __init__(self, units: Sequence[tree.Unit]) -> None:
        self._programs = {
            one.name.casefold(): (unit.file, one)
            for unit in units
            for one in unit.declarations
            if isinstance(one, tree.Pou) and one.kind is tree.PouKind.PROGRAM
        }
        self._copies: dict[str, tuple[str, tree.Pou]] = {}
        """The files of the copies, and the copies, by their names, which no program can have."""

    def with_copies(self, unit: tree.Unit) -> tree.Unit:
        """Return a unit with the copies of its programs."""
        copies = tuple(copy for file, copy in self._copies.values() if file == unit.file)
        return replace(unit, declarations=(*unit.declarations, *copies)) if copies else unit

    def replaced(self, parts: Sequence[tree.Test]) -> list[tree.Test]:
        """Return the parts of one test without such variables; its statements name programs instead of them."""
        names: dict[str, str] = {}
        counts: Counter[str] = Counter()
        for variable in (one for part in parts for block in part.blocks for one in block.variables):
            if self._is_program(variable):
                assert isinstance(variable.type, tree.NamedType)
                key = variable.type.name.casefold()
                counts[key] += 1
                names[variable.name.casefold()] = self._named(key, counts[key])
        return [_with_names(part, names) for part in parts] if names else list(parts)

    def _is_program(self, variable: tree.Variable) -> bool:
        """True if it is declared as a program and nothing more; with a start value it stays the mistake that it is."""
        kind = variable.type
        is_plain = variable.initial is None and variable.location is None and not variable.place
        return is_plain and isinstance(kind, tree.NamedType) and kind.name.casefold() in self._programs

    def _named(self, key: str, number: int) -> str:
        file, program = self._programs[key]
        if number == 1:
            return program.name
        name = f"{program.name} {number}"
        if name not in self._copies:
            copy = deepcopy(program)
            copy.name = name
            self._copies[name] = file, copy
        return name


def _with_names(part: tree.Test, names: dict[str, str]) -> tree.Test:
    blocks = (_without(block, names) for block in part.blocks)
    body = deepcopy(part.body)
    for node in tree.walk(body):
        if isinstance(node, tree.Name):
            node.text = names.get(node.text.casefold(), node.text)
    return replace(part, blocks=tuple(block for block in blocks if block.variables), body=body)


def _without(block: tree.Variables, names: Collection[str]) -> tree.Variables:
    return replace(block, variables=tuple(one for one in block.variables if one.name.casefold() not in names))
