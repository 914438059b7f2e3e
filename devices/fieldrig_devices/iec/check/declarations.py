"""All declarations of a project, in the order of work: names, types, variables, start values."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from fieldrig_devices.iec import any_types, tree
from fieldrig_devices.iec.check import (
    access,
    classes,
    dispatch,
    enum_texts,
    inheritance,
    initials,
    interfaces,
    properties,
    resources,
)
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.project import UNKNOWN, Entity, Pending, PouSource, Project, Start
from fieldrig_devices.iec.check.sizes import DEEPEST, Refused, Sizes
from fieldrig_devices.iec.check.type_specs import BIT, TypeSpecs
from fieldrig_devices.iec.check.variables import Variables
from fieldrig_devices.iec.elementary import ALIASES, LONG_ALIASES, OF_EDITION_3, Elementary
from fieldrig_devices.iec.program import Constant, Pou, Space, Variable
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import BlockType, StringType, Type


class Declarations:
    def __init__(self, project: Project, library_files: frozenset[str], resource: str = "") -> None:
        """`resource` is the one that runs, if the project has several."""
        self._project, self._library_files, self._resource = project, library_files, resource
        self._chosen = ""
        self._foreign: list[tuple[tree.Variables, str]] = []
        """The global variables of other resources."""
        self.specs = TypeSpecs(project)
        project.specs = self.specs
        self.variables = Variables(project, self.specs)
        self.configurations: list[tuple[tree.Configuration, str]] = []
        self._trees: dict[str, tuple[tree.Pou, str]] = {}
        """The POUs by name with their files, for those that extend them."""
        self._config_blocks: list[tuple[tree.Variables, str]] = []
        self._structures = 0
        """How many structures have the start values of their components."""
        has_long = project.dialect.has_long_types
        names = {str(kind): kind for kind in Elementary if has_long or kind not in OF_EDITION_3}
        durations = project.dialect.durations
        names |= {str(kind): form for kind, form in durations.items() if has_long or kind not in OF_EDITION_3}
        long_aliases = {name: durations.get(kind, kind) for name, kind in LONG_ALIASES.items()}
        names |= {**ALIASES, **(long_aliases if has_long else {})}
        project.types.update({name.lower(): kind for name, kind in names.items()})
        project.types["string"] = StringType()
        if project.dialect.has_wide_strings:
            project.types["wstring"] = StringType(is_wide=True)
        if project.dialect.has_bits:
            project.types[BIT] = Elementary.BOOL
        if project.dialect.has_any_inputs:
            project.types.update(dict.fromkeys(any_types.NAMES, any_types.DESCRIPTION))
        project.types.update(project.host.object_types)
        project.compute = self._compute

    def _compute(self, start: Start) -> None:
        context = Context(self._project, start.source, start.file)
        if start.source is None:
            context.listed = self._project.lists.get(self._project.key(start.variable.name.partition(".")[0]), {})
        initials.compute(start, context)

    def declare(self, units: Sequence[tree.Unit]) -> None:
        """Work out all declarations; afterwards only bodies are open.

        The libraries come first, so that the project may redefine a name of theirs, for itself alone.
        """
        self._chosen = resources.chosen(self._project, units, self._resource)
        self._note_extended(units)  # also those of the libraries that the project extends
        self._objects()
        objects = set(self._project.names)
        self._part([unit for unit in units if unit.file in self._library_files])
        self._project.library_names = {*self._project.names, *self.specs.names} - objects
        self._part([unit for unit in units if unit.file not in self._library_files])
        self.specs.finish_enumerations()
        self._component_starts()
        self._sizes()
        self._starts()

    def _note_extended(self, units: Sequence[tree.Unit]) -> None:
        for unit in units:
            for node in unit.declarations:
                if isinstance(node, tree.Pou) and node.extends:
                    self._project.extended.add(self._project.key(inheritance.unqualified(node.extends)))

    def _part(self, units: Sequence[tree.Unit]) -> None:
        sources = len(self._project.sources)
        for unit in units:
            for node in unit.declarations:
                if isinstance(node, tree.Pou):
                    self._trees.setdefault(self._project.key(node.name), (node, unit.file))
        declared = [(node, unit.file) for unit in units for node in unit.declarations]
        for node, file in sorted(declared, key=lambda item: isinstance(item[0], tree.Variables) and bool(item[0].name)):
            self._declare(node, file)
        inheritance.check_interfaces(self._project)
        for name in [name for name in self._project.interfaces if not self._project.facades[name].methods]:
            self._methods_of_interface(name)
        self._foreign_lists()
        self.specs.resolve_all()
        self._type_defaults()
        self._component_starts()
        added = list(self._project.sources.values())[sources:]
        for source in added:
            self.variables.add_to_pou(source)
        for source in added:
            interfaces.check(self._project, self.specs, source)
            classes.check(self._project, source)

    # ---- names

    def _objects(self) -> None:
        """Configuration objects, and `_Name` for the logical address of each (PD-025)."""
        for known in self._project.host.objects.values():
            name = self._project.key(known.name)
            self._project.declare(name, Constant(known.address, known.type), "", tree.NOWHERE)
            self._project.declare(f"_{name}", Constant(known.address, Elementary.DINT), "", tree.NOWHERE)

    def _declare(self, node: tree.Declaration, file: str) -> None:
        match node:
            case tree.TypeDeclaration():
                name = self._project.key(node.name)
                if self._is_free(name, node.name, node, file):
                    self._project.declared_at[name] = (file, node.position)
                    self.specs.add(name, node, Context(self._project, None, file))
                    texts = enum_texts.function_of(node, self._project.dialect)
                    if texts is not None:
                        self._pou(texts, "")
            case tree.Interface():
                if self._is_free(self._project.key(node.name), node.name, node, file):
                    self._project.interfaces[self._project.key(node.name)] = node, file
                    self._project.facades[self._project.key(node.name)] = dispatch.facade(node.name, file)
            case tree.Pou():
                self._pou(node, file)
            case tree.Variables():
                self._list(node, file)
            case tree.Configuration():
                for part in resources.parts(node):
                    self._configuration(part, file)

    def _configuration(self, node: tree.Configuration, file: str) -> None:
        if node.resource and self._project.key(node.resource) != self._chosen:
            self._foreign += [(block, file) for block in node.blocks]
            return
        self.configurations.append((node, file))
        for block in node.blocks:
            self._list(block, file)

    def _foreign_lists(self) -> None:
        """Declare the global variables of the resources that do not run, except for names that have a meaning."""
        for block, file in self._foreign:
            free = [node for node in block.variables if self._project.key(node.name) not in self._project.names]
            self._list(replace(block, variables=tuple(free)), file)
        self._foreign.clear()

    def _is_free(self, name: str, shown: str, node: tree.Node, file: str) -> bool:
        """POUs, types, global variables and enumeration values share one space of names (PD-357)."""
        project = self._project
        if isinstance(node, tree.Pou) and self._is_value_of_enumeration(name):
            return True
        is_known = self._is_known(name) and not self._shares(name, node)
        if is_known and name in project.library_names:
            project.reports.note(file, node.position, f"{shown} replaces the one of the library")
            project.replace(name)
            self.specs.forget(name)
            return True
        if is_known:
            what = (
                f"{shown} is declared {project.where(name)} already"
                if name in project.declared_at
                else f"{shown} is the name of a type"
            )
            project.reports.say(file, node.position, what, "a name that is unique in the project (PD-357)")
        return not is_known

    def _is_value_of_enumeration(self, name: str) -> bool:
        """True for a name that only an enumeration has: a POU takes it, and the value is found by its type."""
        project = self._project
        is_other = any(name in known for known in (project.pous, self.specs.names, project.types))
        return name in project.enumerated and not is_other and not isinstance(project.names.get(name), Variable | Pou)

    def _shares(self, name: str, node: tree.Node) -> bool:
        """True for a variable and a type of the same name, which today's languages allow: `Pump : Pump;`."""
        project = self._project
        if not project.dialect.shares_names_with_types or name in project.library_names:
            return False
        pou = project.pous.get(name)
        is_type = name in self.specs.names or (pou is not None and pou.kind.has_instances)
        if isinstance(node, tree.Variable):
            return is_type and not self._is_variable(name)
        is_new_type = isinstance(node, tree.TypeDeclaration) or (isinstance(node, tree.Pou) and node.kind.has_instances)
        return is_new_type and not is_type and name not in project.types and self._is_variable(name)

    def _is_variable(self, name: str) -> bool:
        return name in self._project.names and not isinstance(self._project.names[name], Pou)

    def _is_known(self, name: str) -> bool:
        project = self._project
        return any(name in known for known in (project.names, project.pous, self.specs.names, project.types))

    def _is_taken(self, name: str) -> bool:
        """True if the project itself has given a name a meaning already."""
        return self._is_known(name) and name not in self._project.library_names

    def _pou(self, node: tree.Pou, file: str) -> None:
        name = self._project.key(node.name)
        has_name = self._is_value_of_enumeration(name) or not self._is_variable(name)
        if not self._is_free(name, node.name, node, file):
            return
        pou = Pou(node.kind, node.name, file, is_native=isinstance(node.body, tree.NativeBody))
        if node.kind is not PouKind.FUNCTION:
            pou.type = BlockType(node.name, pou)
        if node.kind is PouKind.PROGRAM:
            pou.instance = Variable(
                node.name, pou.type or UNKNOWN, Space.GLOBAL, Section.GLOBAL, position=node.position, file=file
            )
            self._project.globals[name] = pou.instance
        self._project.pous[name] = pou
        self._project.sources[pou] = source = PouSource(pou, node, file in self._library_files)
        if has_name:
            self._project.declare(name, pou, file, node.position)
        source.line = inheritance.lineage(self._project, node, file, self._trees)
        for level, (above, home) in enumerate(source.line.trees):
            for action in above.actions:
                self._action(action, source, level, home)
            for method in above.methods:
                self._method(method, source, level, home, above)
            if level:
                inheritance.add_body(source, above, level, home)
        for block in node.blocks:
            if block.section is Section.GLOBAL and node.kind is PouKind.PROGRAM:
                self._list(block, file)

    def _methods_of_interface(self, name: str) -> None:
        """Declare the methods of an interface, and of those that it extends, as dispatchers."""
        facade = self._project.facades[name]
        outer = dispatch.source_of(facade)
        for interface, file in inheritance.closure(self._project, [name]):
            for method in interface.methods:
                title = properties.name_to_write(method.name) if method.accessor == "SET" else method.name
                if self._project.key(title) not in facade.methods:
                    self._method(method, outer, 0, file, outer.tree)

    def _action(self, node: tree.Action, source: PouSource, level: int, file: str) -> None:
        name, pou = self._project.key(node.name), source.pou
        if level and (name in pou.actions or name in pou.methods):
            return
        if name in pou.actions:
            self._project.reports.say(
                pou.file, node.position, f"{pou.name} has two actions {node.name}", "another name"
            )
            return
        if pou.kind is PouKind.FUNCTION:
            self._project.reports.say(
                pou.file, node.position, "an action of a function", "an action of a program or function block"
            )
        pou.actions[name] = Pou(pou.kind, f"{pou.name}.{node.name}", file, pou.variables, type=pou.type, owner=pou)
        source.actions[name] = node, level

    def _method(self, node: tree.Method, outer: PouSource, level: int, file: str, home: tree.Pou) -> None:
        """Declare a method as a function that works with an instance; one that is overridden has a further name."""
        project, pou = self._project, outer.pou
        name = project.key(node.name)
        blocks = node.blocks
        if node.accessor:
            project.properties.add(name)
        if node.accessor == "SET":
            node, blocks = _writer(node)
            name = project.key(node.name)
        versions = outer.line.versions.setdefault(name, []) if outer.line is not None else []
        if pou.kind is PouKind.FUNCTION:
            project.reports.say(pou.file, node.position, "a method of a function", "a method of a function block")
        elif name in pou.actions or (versions and versions[-1][0] == level):
            what = f"{pou.name} has two actions or methods {node.name}"
            project.reports.say(pou.file, node.position, what, "another name")
        else:
            title = f"{node.name}@{level}" if versions else node.name
            made = Pou(PouKind.FUNCTION, f"{pou.name}.{title}", file, owner=pou, is_accessor=bool(node.accessor))
            versions.append((level, made))
            name = f"{name}@{level}" if name in pou.methods else name
            own = tree.Pou(
                PouKind.FUNCTION,
                node.name,
                node.result,
                blocks,
                node.body,
                modifiers=node.modifiers,
                position=node.position,
            )
            access.guard(project, made, node.modifiers, home, level)
            pou.methods[name] = project.pous[f"{project.key(pou.name)}.{name}"] = made
            project.sources[made] = PouSource(made, own, outer.is_library, outer=outer, level=level)

    def _list(self, block: tree.Variables, file: str) -> None:
        match block.section:
            case Section.GLOBAL:
                self.variables.add_globals(
                    block, file, lambda name, entity, node: self._global(name, entity, node, file), self._is_taken
                )
            case Section.CONFIG:
                self._config_blocks.append((block, file))
            case _:
                self._project.reports.say(
                    file, block.position, f"{block.section.value} outside a POU", "VAR_GLOBAL, or a POU around it"
                )

    def _global(self, name: str, entity: Entity | Pending, node: tree.Variable, file: str) -> bool:
        if not self._is_free(name, node.name, node, file):
            return False
        self._project.declare(name, entity, file, node.position)
        return True

    # ---- start values

    def _type_defaults(self) -> None:
        """Work out the start values of declared types."""
        for name, node, context in self.specs.default_sources():
            if name in self._project.defaults:
                continue
            kind = self._project.types.get(name, UNKNOWN)
            start = initials.value(node.initial, kind, context) if node.initial is not None else None
            if start is not None:
                self._project.defaults[name] = start

    def _component_starts(self) -> None:
        """Work out the start values of components in the structures that have been added since the last call.

        Structures without a name are added with the variables that have them as their type.
        """
        added = self.specs.structures[self._structures :]
        self._structures += len(added)
        for structure, spec, context in added:
            for part in spec.fields:
                field = structure.fields.get(self._project.key(part.name))
                if field is None:
                    continue
                if part.initial is not None:
                    field.initial = initials.value(part.initial, field.type, context)
                else:
                    field.initial = self.variables.default(part.type, field.type)

    def _starts(self) -> None:
        starts: list[Start] = list(self._project.starts.values())
        for start in starts:
            self._project.compute(start)

    # ---- sizes

    def _sizes(self) -> None:
        sizes = Sizes(self._project)
        for structure, _, _ in self.specs.structures:
            sizes.of(structure)
        for pou in self._project.sources:
            if pou.type is not None:
                sizes.of(pou.type)
        positions: dict[Type, tuple[str, tree.Position]] = {
            structure: (context.file, spec.position) for structure, spec, context in self.specs.structures
        }
        for kind, why in sizes.refused.items():
            file, position = self._project.declared_at.get(self._project.key(kind.name)) or positions[kind]
            expected, hint = _EXPECTED[why]
            expected = expected.format(parts=self._project.limits.parts)
            self._project.reports.say(file, position, f"{kind or 'the structure'} {why.value}", expected, hint)
        sizes.cut()

    @property
    def config_blocks(self) -> list[tuple[tree.Variables, str]]:
        """The blocks VAR_CONFIG."""
        return self._config_blocks


_EXPECTED: Final = {
    Refused.CIRCLE: ("a type of limited size", "use a POINTER TO it instead"),
    Refused.DEEP: (f"at most {DEEPEST} levels", ""),
    Refused.LARGE: ("at most {parts} components and elements", ""),
}
"""The expectation of the message about a type that cannot be used, and its hint."""


def _writer(node: tree.Method) -> tuple[tree.Method, tuple[tree.Variables, ...]]:
    """Return the method that writes a property, and its variables, of which the first is the value."""
    value = tree.Variable(node.name, node.result or tree.NamedType("BOOL"), position=node.position)
    inputs = tree.Variables(tree.Section.INPUT, (value,), position=node.position)
    return replace(node, name=properties.name_to_write(node.name), result=None), (inputs, *node.blocks)
