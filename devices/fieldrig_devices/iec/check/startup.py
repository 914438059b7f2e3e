"""The code before the first cycle: FB_init of each instance, and start values that are computed.

Source: the public descriptions of CODESYS V3 and TwinCAT 3.  All variables have their constant start values first.
Then the members of an instance are started, after them FB_init of the function blocks that it extends, from the top,
and its own.  What the declaration assigns behind that, `motor : Motor(3) := (speed := 5)`, is assigned last.

The code is made as a tree and checked like any other: a method `$start` for each function block and program that needs
it, and functions `$start0` and so on, which the first program that runs calls.  Variables of functions are started in
each call.
"""

from collections.abc import Iterable, Iterator, Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check.project import START, PouSource, Project, Start
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    AnyStatement,
    Assign,
    CallFunction,
    Cell,
    Constant,
    Evaluate,
    If,
    Load,
    Operator,
    Pou,
    Space,
    Unary,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import ArrayType, BlockType, PointerType, StructType, Type

COUNTER: Final = "$element"
MOST_LOOPS: Final = 3
"""Dimensions of arrays of instances, one within the other."""
FLAG: Final = "$isStarted"
INIT: Final = "fb_init"
WHOLE: Final = "whole"
"""The VAR_IN_OUT of a function that starts the instances in a structure."""
IMPLICIT: Final = (
    tree.Literal(tree.LiteralKind.BOOL, True, "TRUE"),
    tree.Literal(tree.LiteralKind.BOOL, False, "FALSE"),
)
"""The arguments bInitRetains and bInCopyCode, which no declaration gives."""
OWN: Final = frozenset({Section.LOCAL, Section.TEMP})
"""The variables of a function that it may compute at the beginning of each call."""


def may_compute(project: Project, start: Start) -> bool:
    """True if the start value of a variable may be computed when the program starts."""
    variable = start.variable
    if not project.dialect.computes_starts or variable.is_constant or variable.location is not None:
        return False
    if start.source is None:
        return variable.section is Section.GLOBAL
    return variable.space is not Space.FRAME or variable.section in OWN


class Startup:
    """The code that starts a project.  `begin` makes it as trees, and `finish` calls it from the programs."""

    def __init__(self, project: Project) -> None:
        self._project = project
        project.startup = self
        self._loops = 0
        """The number of loops around the present statement."""
        self._needs: dict[Pou, bool] = {}
        self._structures: dict[StructType, bool] = {}
        """The structures, and whether instances in them have to be started."""
        self._functions: dict[str, Pou] = {}
        """The functions `$start` by file, so that messages have the right one."""
        self._statements: dict[str, list[tree.AnyStatement]] = {}
        """The bodies of these functions."""
        self._starters: dict[StructType, str] = {}
        """The functions that start the instances in a structure: without them, the code would grow exponentially with
        structures in one another."""
        self._constructors_of: dict[Pou, list[str]] = {}

    def begin(self) -> None:
        project = self._project
        if not project.dialect.computes_starts:
            return
        for source in list(project.sources.values()):
            if source.pou.type is not None and self._is_needed(source.pou):
                self._add_method(source)
        for variable in self._globals():
            self._add_to_function(variable.file, self._started(variable, variable.name))
        for pou in list(project.pous.values()):
            if pou.kind is PouKind.PROGRAM and self._is_needed(pou):
                self._add_to_function(pou.file, [_call(tree.Member(tree.Name(pou.name), START))])
        for file, function in self._functions.items():
            source = project.sources[function]
            source.tree.body = tree.StBody(tuple(self._statements[file]))
            if _has_loop(self._statements[file]):
                _count_with(source)
        if self._functions:
            project.globals[FLAG.lower()] = Variable(FLAG, Elementary.BOOL, Space.GLOBAL, Section.GLOBAL)

    def finish(self) -> None:
        if not self._functions:
            return
        flag = Cell(self._project.globals[FLAG.lower()], Elementary.BOOL)
        extension = self._project.extension
        first = [pou for task in self._project.tasks for pou in task.programs]
        for pou in dict.fromkeys([*first, *(extension.first(self._project) if extension is not None else [])]):
            line = self._project.sources[pou].tree.position.line
            run: list[AnyStatement] = [Assign(flag, Constant(True, Elementary.BOOL), line=line)]
            functions = self._functions.values()
            run += [Evaluate(CallFunction(function, (), Elementary.BOOL), line=line) for function in functions]
            pou.body.insert(0, If(Unary(Operator.NOT, Load(flag), Elementary.BOOL), run, line=line))

    def in_calls(self, source: PouSource) -> list[tree.AnyStatement]:
        """Return what a body does first in each call, for its variables on the stack."""
        if not self._project.dialect.computes_starts:
            return []
        own = [variable for variable in source.pou.variables.values() if variable.space is Space.FRAME]
        statements = [one for variable in own for one in self._started(variable, variable.name)]
        if _has_loop(statements):
            _count_with(source)
        return statements

    def of_new(self, target: tree.Expression, kind: Type, spec: tree.TypeSpec) -> Iterator[tree.AnyStatement]:
        """Yield the statements that start what a pointer points to; `spec` has the arguments of FB_init."""
        return self._instances(target, kind, spec)

    # ---- what needs a start

    def _globals(self) -> list[Variable]:
        """The global variables with a name of their own, without the instances of programs."""
        variables = self._project.globals.items()
        return [one for name, one in variables if self._project.names.get(name) is one]

    def _is_needed(self, pou: Pou) -> bool:
        if pou not in self._needs:
            self._needs[pou] = False
            own = [variable for variable in pou.variables.values() if variable.space is Space.INSTANCE]
            self._needs[pou] = any(self._needs_start(variable) for variable in own)
        return self._needs[pou]

    def _needs_start(self, variable: Variable) -> bool:
        if variable in self._project.computed:
            return True
        return not variable.is_reference and self._has_instances(variable.type)

    def _has_instances(self, kind: Type) -> bool:
        """True if a type is or contains a function block that has to be started."""
        while isinstance(kind, ArrayType):
            kind = kind.element
        if isinstance(kind, StructType):
            if kind not in self._structures:
                self._structures[kind] = any(self._has_instances(field.type) for field in kind.fields.values())
            return self._structures[kind]
        block = _block(kind)
        return block is not None and (self._constructors(block) != [] or self._is_needed(block))

    def _constructors(self, block: Pou) -> list[str]:
        """Return the names of the FB_init of a block and of those above it, the uppermost first."""
        if not self._project.dialect.has_constructors:
            return []
        if block not in self._constructors_of:
            names = [name for name in block.methods if name.partition("@")[0] == INIT]
            self._constructors_of[block] = sorted(names, reverse=True)
        return self._constructors_of[block]

    def _is_constructed(self, kind: Type) -> bool:
        block = _block(kind)
        return block is not None and self._constructors(block) != []

    # ---- the code

    def _add_to_function(self, file: str, statements: Iterable[tree.AnyStatement]) -> None:
        made = tuple(statements)
        if not made:
            return
        if file not in self._functions:
            name = f"{START}{len(self._functions)}"
            function = self._functions[file] = self._project.pous[name] = Pou(PouKind.FUNCTION, name, file)
            node = tree.Pou(PouKind.FUNCTION, name, None, (), tree.StBody(()))
            self._project.sources[function] = PouSource(function, node, is_library=False)
        self._statements.setdefault(file, []).extend(made)

    def _add_method(self, source: PouSource) -> None:
        """Give a function block or program its method `$start`."""
        pou, project = source.pou, self._project
        own = [variable for variable in pou.variables.values() if variable.space is Space.INSTANCE]
        body = [one for variable in own for one in self._started(variable, variable.name)]
        node = tree.Pou(PouKind.FUNCTION, START, None, (), tree.StBody(tuple(body)), position=source.tree.position)
        made = Pou(PouKind.FUNCTION, f"{pou.name}.{START}", pou.file, owner=pou)
        pou.methods[START] = project.pous[f"{project.key(pou.name)}.{START}"] = made
        project.sources[made] = own_source = PouSource(made, node, source.is_library, outer=source)
        if _has_loop(body):
            _count_with(own_source)

    def _started(self, variable: Variable, name: str) -> Iterator[tree.AnyStatement]:
        """Yield the statements that start a variable of the code that has it."""
        if not self._needs_start(variable):
            return
        node = self._project.declared.get(variable)
        spec = node.type if node is not None else _PLAIN
        target = tree.Name(name, position=variable.position)
        yield from self._instances(target, variable.type, spec)
        is_computed = variable in self._project.computed
        if node is not None and node.initial is not None and (is_computed or self._is_constructed(variable.type)):
            yield from _assignments(target, variable.type, node.initial)

    def _instances(
        self, target: tree.Expression, kind: Type, spec: tree.TypeSpec, at: int = 0
    ) -> Iterator[tree.AnyStatement]:
        if not self._has_instances(kind):
            return
        if isinstance(kind, StructType):
            starter = tree.Name(self._starter(kind), position=target.position)
            yield _call(starter, [tree.Argument(target, WHOLE)])
            return
        if isinstance(kind, ArrayType):
            yield from self._elements(target, kind, spec, at)
            return
        block = _block(kind)
        assert block is not None
        if self._is_needed(block):
            yield _call(tree.Member(target, START, position=target.position))
        rows = spec.rows if isinstance(spec, tree.NamedType) else ()
        given = rows[at] if at < len(rows) else spec.arguments if isinstance(spec, tree.NamedType) else ()
        for name in self._constructors(block):
            yield _call(tree.Member(target, name, position=target.position), self._fitting(block.methods[name], given))

    def _starter(self, kind: StructType) -> str:
        """Return the name of the function that starts the instances in a structure."""
        if kind not in self._starters:
            project, file = self._project, ""
            name = self._starters[kind] = f"{START}@{len(self._starters)}"
            made = project.pous[name] = project.names[name] = Pou(PouKind.FUNCTION, name, file)
            whole = made.variables[WHOLE] = Variable(WHOLE, kind, Space.FRAME, Section.IN_OUT)
            loops, self._loops = self._loops, 0
            body = [
                one
                for field in kind.fields.values()
                for one in self._instances(tree.Member(tree.Name(WHOLE), field.name), field.type, _PLAIN)
            ]
            self._loops = loops
            node = tree.Pou(PouKind.FUNCTION, name, None, (), tree.StBody(tuple(body)))
            source = project.sources[made] = PouSource(made, node, False, {WHOLE: whole}, [whole])
            if _has_loop(body):
                _count_with(source)
        return self._starters[kind]

    def _elements(
        self, target: tree.Expression, kind: ArrayType, spec: tree.TypeSpec, at: int
    ) -> Iterator[tree.AnyStatement]:
        """Start the elements of an array in a loop, or one by one if each has arguments of its own."""
        inner = spec
        while isinstance(inner, tree.ArraySpec):
            inner = inner.element
        if isinstance(inner, tree.NamedType) and inner.rows:
            for number in range(kind.count):
                element = _element(target, kind.low + number)
                yield from self._instances(element, kind.element, inner, at * kind.count + number)
            return
        counter = tree.Name(f"{COUNTER}{self._loops}")
        self._loops += 1
        element = tree.Index(target, (counter,), position=target.position)
        body = tuple(self._instances(element, kind.element, inner))
        self._loops -= 1
        yield tree.For(counter, _number(kind.low), _number(kind.high), None, body, position=target.position)

    def _fitting(self, method: Pou, given: Sequence[tree.Argument]) -> Sequence[tree.Argument]:
        """Return the arguments for the FB_init of one level; that of a derived block has those of its base in front."""
        inputs = self._project.sources[method].inputs
        names = {self._project.key(one.name) for one in inputs}
        implicit = [tree.Argument(value) for value in IMPLICIT[: len(inputs)]]
        is_above = "@" in method.name
        rest = [one for one in given if not is_above or not one.name or self._project.key(one.name) in names]
        return [*implicit, *(rest[: len(inputs) - len(implicit)] if is_above else rest)]


_PLAIN: Final = tree.NamedType("")
"""Stands for the type of what has no arguments of its own."""


def _block(kind: Type) -> Pou | None:
    while isinstance(kind, ArrayType):
        kind = kind.element
    return kind.pou if isinstance(kind, BlockType) else None


def _call(called: tree.Expression, arguments: Sequence[tree.Argument] = ()) -> tree.CallStatement:
    return tree.CallStatement(tree.Call(called, tuple(arguments), position=called.position), position=called.position)


def _number(value: int) -> tree.Literal:
    return tree.Literal(tree.LiteralKind.INTEGER, value, str(value))


def _element(target: tree.Expression, index: int) -> tree.Index:
    return tree.Index(target, (_number(index),), position=target.position)


def _count_with(source: PouSource) -> None:
    """Give a body that has loops the variables that count in them."""
    for number in range(MOST_LOOPS):
        name = f"{COUNTER}{number}"
        counter = Variable(name, Elementary.DINT, Space.FRAME, Section.TEMP, file=source.pou.file)
        source.names[name] = source.pou.variables[name] = counter


def _has_loop(statements: Iterable[tree.AnyStatement]) -> bool:
    return any(isinstance(one, tree.For) for one in statements)


def _assignments(target: tree.Expression, kind: Type, initial: tree.Initial) -> Iterator[tree.AnyStatement]:
    """Yield the assignments of a start value, part by part."""
    match initial:
        case tree.StructInitial(fields):
            for field in fields:
                member = tree.Member(target, field.name, position=field.position)
                yield from _assignments(member, _part(kind, field.name), field.value)
        case tree.ArrayInitial(elements) if isinstance(kind, ArrayType):
            index = kind.low
            for element in elements:
                count = _count(element)
                value = element.value if isinstance(element, tree.Repeated) else element
                for number in range(index, index + count):
                    yield from _assignments(_element(target, number), kind.element, value)
                index += count
        case tree.ArrayInitial():
            return
        case _:
            is_reference = isinstance(kind, PointerType) and kind.is_reference
            how = tree.AssignKind.REFER if is_reference else tree.AssignKind.PLAIN
            yield tree.Assign(target, initial, how, position=initial.position)


def _count(element: tree.Initial | tree.Repeated) -> int:
    """The number of repetitions, which is a number in the text."""
    if not isinstance(element, tree.Repeated):
        return 1
    count = element.count
    return int(count.value) if isinstance(count, tree.Literal) and isinstance(count.value, int) else 0


def _part(kind: Type, name: str) -> Type:
    """The type of a component; that of a property does not matter."""
    if isinstance(kind, BlockType) and kind.pou is not None:
        variable = kind.pou.variables.get(name.lower())
        return variable.type if variable is not None else Elementary.BOOL
    fields = getattr(kind, "fields", {})
    return fields[name.lower()].type if name.lower() in fields else Elementary.BOOL
