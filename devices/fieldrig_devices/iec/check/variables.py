"""Declarations of variables: the blocks VAR to VAR_GLOBAL, with their sections, attributes, addresses and types."""

from collections.abc import Callable
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import access, dispatch, edges, enable, open_arrays
from fieldrig_devices.iec.check.context import Context
from fieldrig_devices.iec.check.located import location
from fieldrig_devices.iec.check.project import UNKNOWN, Pending, PouSource, Project, Start
from fieldrig_devices.iec.check.texts import a
from fieldrig_devices.iec.check.type_specs import TypeSpecs, block_of, comment_of
from fieldrig_devices.iec.program import CLASS, Space, Variable
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import ArrayType, EnumType, InitialValue, ObjectType, Type

IN_CLASSES: Final = frozenset({Section.LOCAL, Section.STATIC, Section.EXTERNAL, Section.CONFIG, Section.GLOBAL})
"""The sections of a class, and those that have a message of their own in every POU."""
INTERFACE: Final = frozenset({Section.INPUT, Section.OUTPUT, Section.IN_OUT})
LOCATED: Final = frozenset({Section.LOCAL})
LOCATED_TODAY: Final = frozenset({Section.LOCAL, Section.INPUT, Section.OUTPUT})
"""The sections of a POU with addresses."""
MAY_BE_CONSTANT: Final = frozenset({Section.LOCAL, Section.GLOBAL, Section.EXTERNAL})


def _comes_later(block: tree.Variables) -> bool:
    """False for the constants of a POU, which the types of variables in front of them may need."""
    return block.section is not Section.LOCAL or not block.is_constant


def _put_in_order(variables: dict[str, Variable], pou: tree.Pou, project: Project) -> None:
    """Put the variables of a POU into the order of its text, in which they have their places in memory."""
    blocks = [_comes_later(block) for block in pou.blocks]
    if blocks == sorted(blocks):
        return
    names = [project.key(node.name) for block in pou.blocks for node in block.variables]
    own = {name: variables.pop(name) for name in names if name in variables}
    variables.update(own)


class Variables:
    def __init__(self, project: Project, specs: TypeSpecs) -> None:
        self._project, self._specs = project, specs
        self.lists: list[tuple[list[Variable], tree.Variables, str]] = []
        """The lists of global variables, for the limit of their size (PD-316)."""
        self.incomplete: dict[Variable, tree.Direct] = {}
        """Variables with an address such as %I*, which VAR_CONFIG completes."""

    # ---- global variables

    def add_globals(
        self,
        block: tree.Variables,
        file: str,
        declare: Callable[[str, Pending, tree.Variable], bool],
        is_taken: Callable[[str], bool],
    ) -> None:
        """Note a list of global variables.  Each is made at its first use, since types may need constants.

        A variable of a named list whose own name is taken already, and each of a list with the attribute
        'qualified_only', is known by `list.variable` only.
        """
        context = Context(self._project, None, file)
        if block.name:
            context.listed = self._project.lists.setdefault(self._project.key(block.name), {})
        members: list[Variable] = []
        self.lists.append((members, block, file))
        for node in block.variables:
            name = self._project.key(node.name)
            full = node.name
            if block.name and self._project.dialect.has_name_spaces and (block.is_qualified or is_taken(name)):
                full = f"{block.name}.{node.name}"
            if block.name:
                listed = self._project.lists.setdefault(self._project.key(block.name), {})
                listed[name] = self._project.key(full)
            name = self._project.key(full)

            def make(node: tree.Variable = node, name: str = name, full: str = full) -> Variable:
                made = self._make(node, block, Space.GLOBAL, Section.GLOBAL, None, context)
                made.name = full
                self._project.globals[name] = made
                members.append(made)
                return made

            declare(name, Pending(make), node)

    # ---- variables of a POU

    def add_to_pou(self, source: PouSource) -> None:
        context = Context(self._project, source, source.pou.file)
        pou = source.pou
        if source.tree.result is not None:
            kind = self._specs.resolve(source.tree.result, context)
            name = source.tree.name
            pou.result = Variable(name, kind, Space.FRAME, Section.OUTPUT, position=source.tree.position, file=pou.file)
            pou.result.initial = self.default(source.tree.result, kind)
            source.names[self._project.key(name)] = pou.result
        elif pou.kind is PouKind.FUNCTION and pou.owner is None and not self._project.dialect.has_void_functions:
            context.say(source.tree, f"the function {pou.name} has no type", f"FUNCTION {pou.name} : INT")
        line = source.line.trees if source.line is not None else []
        if dispatch.has_class(self._project, source):
            pou.variables[CLASS] = dispatch.class_word(pou)
        for level in range(len(line) - 1, 0, -1):
            above, home = line[level]
            for block in above.blocks:
                for node in block.variables:
                    self._add(node, block, source, Context(self._project, source, home), above, level)
        for block in source.tree.blocks:
            self._check_block(block, source, context)
        for block in sorted(source.tree.blocks, key=_comes_later):
            for node in block.variables:
                self._add(node, block, source, context, source.tree, 0)
        _put_in_order(pou.variables, source.tree, self._project)
        enable.note_declared(self._project, source)

    def _check_block(self, block: tree.Variables, source: PouSource, context: Context) -> None:
        kind, section = source.pou.kind, block.section
        if section is Section.CONFIG:
            context.say(block, "VAR_CONFIG in a POU", "VAR_CONFIG outside all POUs")
        if section is Section.GLOBAL and kind is not PouKind.PROGRAM:
            context.say(block, f"VAR_GLOBAL in {a(kind.value)}", "VAR_GLOBAL in a file of its own or in a program")
        if section is Section.INSTANCE and not source.pou.is_method:
            context.say(block, f"VAR_INST in {a(kind.value)}", "VAR_INST in a METHOD", "use VAR or VAR_STAT")
        if kind is PouKind.FUNCTION and section is not Section.INSTANCE and (block.is_retain or block.is_persistent):
            context.say(block, "RETAIN in a function", "a function keeps nothing between calls (PD-354)")
        if section is Section.GENERIC:
            context.say(block, f"VAR_GENERIC in {a(kind.value)}", "VAR_GENERIC CONSTANT in a FUNCTION_BLOCK")
        is_argument = (
            section in (Section.IN_OUT, Section.INPUT, Section.OUTPUT) and self._project.dialect.has_constant_arguments
        )
        if block.is_constant and section not in MAY_BE_CONSTANT and not is_argument:
            context.say(block, f"{section.value} CONSTANT", "CONSTANT behind VAR, VAR_GLOBAL or VAR_EXTERNAL")
        if kind is PouKind.CLASS and section not in IN_CLASSES:
            hint = "give a METHOD its VAR_INPUT and VAR_OUTPUT"
            context.say(block, f"{section.value} in a class", "VAR, VAR PUBLIC or VAR_EXTERNAL", hint)
        if block.access and (section is not Section.LOCAL or not kind.has_instances):
            where = a(kind.value) if section is Section.LOCAL else section.value
            context.say(block, f"{block.access} in {where}", "VAR PUBLIC in a class or function block")
        if section is Section.TEMP and (block.is_retain or block.is_persistent):
            context.say(block, "VAR_TEMP RETAIN", "variables that keep their value, in VAR RETAIN")

    def _add(
        self,
        node: tree.Variable,
        block: tree.Variables,
        source: PouSource,
        context: Context,
        home: tree.Pou,
        level: int,
    ) -> None:
        if block.section in (Section.CONFIG, Section.GLOBAL):
            return
        name = self._project.key(node.name)
        known = source.names.get(name)
        if known is not None:
            where = f"in line {known.position.line} already" if known.position.line else "already"
            context.say(node, f"{node.name} is declared {where}", "another name, or one declaration (PD-350)")
            return
        if block.section is Section.EXTERNAL:
            source.names[name] = self._external(node, block, context)
            return
        if block.section is Section.STATIC:
            source.names[name] = self._static(node, block, source, context)
            return
        if block.section is Section.INSTANCE:
            source.names[name] = self._of_instance(node, block, source, context)
            return
        made = self._make(node, block, self._space(block.section, source.pou.kind), block.section, source, context)
        source.pou.variables[name] = made
        source.names[name] = edges.in_body(self._project, source, made, node)
        if made.section is Section.LOCAL and home.kind.has_instances:
            access.guard(self._project, made, (block.access,), home, level)
        if made.section in (Section.INPUT, Section.IN_OUT):
            source.inputs.append(made)
        elif made.section is Section.OUTPUT:
            source.outputs.append(made)

    def _static(self, node: tree.Variable, block: tree.Variables, source: PouSource, context: Context) -> Variable:
        """Make a variable that exists once, wherever its function, method or function block is called.

        It is a global variable whose name no other one can have.
        """
        made = self._make(node, block, Space.GLOBAL, Section.STATIC, None, context)
        made.name = f"{source.pou.name}.{node.name}"
        name = self._project.key(made.name)
        self._project.globals[name] = self._project.names[name] = made
        return made

    def _of_instance(self, node: tree.Variable, block: tree.Variables, source: PouSource, context: Context) -> Variable:
        """Make a variable of a method that the instance has, under a name that no other one can have."""
        owner = source.outer or source
        made = self._make(node, block, Space.INSTANCE, Section.LOCAL, owner, context)
        made.name = f"{source.pou.name.partition('.')[2]}.{node.name}"
        if source.pou.is_method:
            name = self._project.key(made.name)
            owner.pou.variables[name] = owner.names[name] = made
        return made

    def _space(self, section: Section, kind: PouKind) -> Space:
        return Space.FRAME if kind is PouKind.FUNCTION or section is Section.TEMP else Space.INSTANCE

    def _external(self, node: tree.Variable, block: tree.Variables, context: Context) -> Variable:
        """VAR_EXTERNAL names a global variable, whose type must agree."""
        kind = self._specs.resolve(node.type, context)
        variable = self._project.find(self._project.key(node.name))
        if not isinstance(variable, Variable):
            hint = self._project.reports.closest(node.name, self._project.globals)
            context.say(node, f"there is no global variable {node.name}", "the name of a VAR_GLOBAL", hint)
            return Variable(node.name, UNKNOWN, Space.GLOBAL, Section.EXTERNAL)
        if kind is not UNKNOWN and variable.type is not UNKNOWN and variable.type != kind:
            context.say(node, f"the VAR_EXTERNAL {node.name} is {a(kind)}", f"{variable.type}, as the global variable")
        return variable

    # ---- one variable

    def _make(
        self,
        node: tree.Variable,
        block: tree.Variables,
        space: Space,
        section: Section,
        source: PouSource | None,
        context: Context,
    ) -> Variable:
        kind = open_arrays.declared(self._specs, node, section, source, context)
        if section is Section.IN_OUT and isinstance(kind, ObjectType):
            section = Section.INPUT  # objects are references anyway (PD-023)
        if isinstance(kind, EnumType) and section is Section.INPUT and context.is_library:
            # A block answers a wrong number with its own error, as PTOMoveRelative does (library guide, 1381 and 1420).
            self._project.values_of(kind)
            kind = kind.as_input()
        made = Variable(
            node.name,
            kind,
            space,
            section,
            is_retain=block.is_retain or block.is_persistent,
            is_constant=block.is_constant and section in (*MAY_BE_CONSTANT, Section.IN_OUT),
            is_fixed=block.is_constant and block.section is Section.INPUT,
            position=node.position,
            file=context.file,
            comment=comment_of(node),
            narrow=self._specs.resolve(node.narrow, context) if node.narrow is not None else None,
        )
        self._project.declared[made] = node
        self._check_type(made, node, source, context)
        edges.check(source, made, node, context)
        if node.location is not None:
            self._locate(made, node.location, source, context)
        if node.initial is None:
            made.initial = self.default(node.type, kind)
        elif made.is_reference:
            what = f"the {section.value} {node.name} has a start value"
            context.say(node, what, "no start value for a reference")
        else:
            self._project.starts[made] = Start(made, node.initial, source, context.file)
        return made

    def _check_type(self, made: Variable, node: tree.Variable, source: PouSource | None, context: Context) -> None:
        block = block_of(made.type)
        spec = node.type
        while isinstance(spec, tree.ArraySpec):
            spec = spec.element
        has_arguments = isinstance(spec, tree.NamedType) and bool(spec.arguments or spec.rows)
        if has_arguments and made.type is not UNKNOWN and (block is None or "fb_init" not in block.methods):
            context.say(spec, f"{made.type} has no method FB_init for the arguments", "the name of the type alone")
        if block is None:
            return
        if made.section is not Section.IN_OUT and self._project.is_abstract(block):
            hint = f"declare a {block.kind.value.lower()} that extends it"
            context.say(node, f"{made.name} is an instance of {block.name}, which is ABSTRACT", "another type", hint)
        elif self._is_misplaced(made, source):
            context.say(
                node,
                f"the instance {made.name} of {block.name} in a function",
                "VAR_IN_OUT for an instance; a function keeps nothing between calls (PD-354)",
            )
        elif made.section in (Section.INPUT, Section.TEMP) and not self._project.dialect.copies_blocks:
            hint = "use VAR_IN_OUT, which passes the instance itself (PD-352)"
            context.say(
                node, f"the instance {made.name} of {block.name} in {made.section.value}", "another section", hint
            )

    def _is_misplaced(self, made: Variable, source: PouSource | None) -> bool:
        """True for an instance in a function that cannot have it."""
        if source is None or source.pou.kind is not PouKind.FUNCTION or made.section is Section.IN_OUT:
            return False
        if made.section is Section.LOCAL:
            return not self._project.dialect.has_local_instances
        return not self._project.dialect.copies_blocks

    def _locate(self, made: Variable, node: tree.Direct, source: PouSource | None, context: Context) -> None:
        sections = LOCATED_TODAY if self._project.dialect.allows_open_addresses else LOCATED
        if source is not None and (source.pou.kind is PouKind.FUNCTION or made.section not in sections):
            context.say(
                node, f"{made.name} has an address", "AT in VAR of a program or function block, or in VAR_GLOBAL"
            )
        elif not node.numbers:
            self.incomplete[made] = node
        elif source is not None and source.pou.kind.has_instances:
            hint = f"write AT %{node.area}* and the address of each instance in VAR_CONFIG"
            context.note(node, f"all instances of {source.pou.name} share the address of {made.name}", hint)
            made.location = location(node, made.type, context)
        elif made.type is not UNKNOWN:
            made.location = location(node, made.type, context)

    def default(self, spec: tree.TypeSpec, kind: Type) -> InitialValue | None:
        """The start value that a declared type gives to its variables, also to the elements of an array of it."""
        if isinstance(spec, tree.NamedType):
            return self._project.defaults.get(self._project.key(spec.name))
        if not isinstance(spec, tree.ArraySpec):
            return None
        counts: list[int] = []
        for _ in spec.dimensions:
            if not isinstance(kind, ArrayType):
                return None
            counts.append(kind.count)
            kind = kind.element
        made = self.default(spec.element, kind)
        for count in reversed(counts):
            made = [made] * count if made is not None else None
        return made
