"""VAR_CONFIG as the standard has it: paths by resource and instance, and start values of instances.

IEC 61131-3:2013, table 62: `VAR_CONFIG Station_1.P1.count : INT := 5; P1.valve.lamp AT %QX1.0 : BOOL; END_VAR`.  An
instance stands for the program that its type names, as `program_instances` has made one for each, and its start values
go into the declarations of that program.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import Dialect

_LONGEST: Final = 100
"""Names in a path; types have fewer levels."""


def configured(units: Sequence[tree.Unit], dialect: Dialect, resource: str) -> Sequence[tree.Unit]:
    """Return the units with paths that begin with a program, and with the start values in the programs.

    `resource` is the resource that runs, empty for the first; what belongs to another one is left out.
    """
    blocks = (block for unit in units for one in unit.declarations for block in _blocks(one))
    if not any(block.section is tree.Section.CONFIG for block in blocks):
        return units
    return _Configured(units, dialect, resource).units()


def _parts(node: tree.Declaration) -> Iterator[tree.Configuration]:
    if isinstance(node, tree.Configuration):
        yield node
        yield from node.resources


def _blocks(node: tree.Declaration) -> Iterator[tree.Variables]:
    if isinstance(node, tree.Variables):
        yield node
    for part in _parts(node):
        yield from part.blocks


@dataclass(slots=True)
class _Start:
    """The start value that a variable, or a part of one, is given here."""

    name: str
    whole: tree.Initial | None = None
    parts: dict[str, "_Start"] = field(default_factory=dict)
    """Start values of its components, which count behind the one of the whole."""

    def made(self, declared: tree.Initial | None, key: Callable[[str], str]) -> tree.Initial | None:
        """Return the start value, where the declaration has `declared`."""
        whole = declared if self.whole is None else self.whole
        if not self.parts:
            return whole
        fields = {key(one.name): one for one in whole.fields} if isinstance(whole, tree.StructInitial) else {}
        for name, part in self.parts.items():
            value = part.made(fields[name].value if name in fields else None, key)
            if value is not None:
                fields[name] = tree.FieldInitial(part.name, value, position=value.position)
        return tree.StructInitial(tuple(fields.values()), position=next(iter(fields.values())).position)


class _Configured:
    def __init__(self, units: Sequence[tree.Unit], dialect: Dialect, resource: str) -> None:
        self._units, self._key = units, dialect.key
        configurations = [one for unit in units for one in unit.declarations if isinstance(one, tree.Configuration)]
        parts = [part for one in configurations for part in _parts(one)]
        self._resources = list(dict.fromkeys(self._key(part.resource) for part in parts if part.resource))
        chosen = self._key(resource)
        self._chosen = chosen if chosen in self._resources else next(iter(self._resources), "")
        self._outer = {self._key(one.name) for one in configurations if one.name} | set(self._resources)
        """The names of configurations and resources, which paths may begin with."""
        self._programs = {
            self._key(instance.name): instance.type
            for part in parts
            if not part.resource or self._key(part.resource) == self._chosen
            for instance in part.programs
        }
        """The programs of the resource that runs, by the names of their instances."""
        self._starts: dict[str, dict[str, _Start]] = {}
        """Start values by programs and their variables."""
        self._variables = {
            self._key(one.name): {self._key(node.name) for block in one.blocks for node in block.variables}
            for unit in units
            for one in unit.declarations
            if isinstance(one, tree.Pou) and one.kind is tree.PouKind.PROGRAM
        }

    def units(self) -> list[tree.Unit]:
        made = [
            replace(unit, declarations=tuple(self._with_paths(one) for one in unit.declarations))
            for unit in self._units
        ]
        return [replace(unit, declarations=tuple(map(self._with_starts, unit.declarations))) for unit in made]

    # ---- paths

    def _with_paths(self, node: tree.Declaration) -> tree.Declaration:
        match node:
            case tree.Variables(section=tree.Section.CONFIG):
                return replace(node, variables=tuple(self._left(node.variables)))
            case tree.Configuration():
                blocks = tuple(self._with_paths(block) for block in node.blocks)
                resources = tuple(self._with_paths(part) for part in node.resources)
                return replace(node, blocks=blocks, resources=resources)  # type: ignore[arg-type]
        return node

    def _left(self, nodes: Sequence[tree.Variable]) -> Iterator[tree.Variable]:
        """Yield the variables with paths that begin with a program, without those that only have a start value."""
        for node in nodes:
            path = node.name.split(".")
            while len(path) > 1 and self._key(path[0]) in self._outer and self._key(path[0]) not in self._variables:
                if self._key(path[0]) in self._resources and self._key(path[0]) != self._chosen:
                    break
                path = path[1:]
            else:
                path[0] = self._programs.get(self._key(path[0]), path[0])
                if not self._is_start(path, node) or node.location is not None:
                    yield replace(node, name=".".join(path))

    def _is_start(self, path: Sequence[str], node: tree.Variable) -> bool:
        """True if a program takes the start value of a path."""
        if node.initial is None or not 2 <= len(path) <= _LONGEST:
            return False
        program, name = self._key(path[0]), self._key(path[1])
        if name not in self._variables.get(program, ()):
            return False
        start = self._starts.setdefault(program, {}).setdefault(name, _Start(path[1]))
        for part in path[2:]:
            start = start.parts.setdefault(self._key(part), _Start(part))
        start.whole, start.parts = node.initial, {}
        return True

    # ---- start values

    def _with_starts(self, node: tree.Declaration) -> tree.Declaration:
        starts = self._starts.get(self._key(node.name)) if isinstance(node, tree.Pou) else None
        if not starts or not isinstance(node, tree.Pou) or node.kind is not tree.PouKind.PROGRAM:
            return node
        return replace(node, blocks=tuple(self._started(block, starts) for block in node.blocks))

    def _started(self, block: tree.Variables, starts: Mapping[str, _Start]) -> tree.Variables:
        def started(node: tree.Variable) -> tree.Variable:
            start = starts.get(self._key(node.name))
            return node if start is None else replace(node, initial=start.made(node.initial, self._key))

        return replace(block, variables=tuple(map(started, block.variables)))
