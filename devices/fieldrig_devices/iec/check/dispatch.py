"""Calls whose code depends on the instance: by an interface, or by a reference to a block that others extend.

An instance that may be called so begins with a hidden word that tells its function block.  For each interface there is
a block that never runs itself, its facade.  Each of its methods is a dispatcher, which compares the word with the
numbers of all function blocks that implement the interface, and runs the method of the right one for the same instance.
A function block that others extend has a facade for all of them, which calls by a pointer, a reference or a VAR_IN_OUT
go through.  All other calls are made directly.
"""

from collections.abc import Callable, Sequence
from typing import Final
from zlib import crc32

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import enable, inheritance, open_arrays
from fieldrig_devices.iec.check.project import PouSource, Project
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    CLASS,
    AddressOf,
    AnyStatement,
    Assign,
    Binary,
    CallBlock,
    CallFunction,
    Cell,
    Component,
    Constant,
    Convert,
    Enable,
    Evaluate,
    Expression,
    If,
    Load,
    Operator,
    Place,
    Pou,
    Space,
    Target,
    This,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import BlockType, InterfaceType, PointerType, Type

EXIT: Final = "fb_exit"
BODY: Final = "$body"
"""The dispatcher of the bodies of function blocks."""


def facade(name: str, file: str) -> Pou:
    """Return a block that has nothing but the word with the function block of the instance, in its first cell."""
    made = Pou(PouKind.FUNCTION_BLOCK, name, file)
    made.type = BlockType(name, made, Elementary.UDINT.size)
    made.variables[CLASS] = Variable(CLASS, Elementary.UDINT, Space.INSTANCE, Section.LOCAL, offset=0, file=file)
    return made


def source_of(made: Pou) -> PouSource:
    """Return the source of a facade, which its methods belong to."""
    return PouSource(made, tree.Pou(PouKind.FUNCTION_BLOCK, made.name, None, (), tree.StBody(())), is_library=False)


def has_class(project: Project, source: PouSource) -> bool:
    """True for a function block that implements an interface, extends another one or is extended."""
    if source.line is None or not source.pou.kind.has_instances:
        return False
    is_above = project.key(source.pou.name) in project.extended
    return is_above or len(source.line.trees) > 1 or bool(inheritance.implemented(source))


def class_word(pou: Pou) -> Variable:
    """Return the hidden word of a function block."""
    word = Variable(CLASS, Elementary.UDINT, Space.INSTANCE, Section.LOCAL, _number(pou), file=pou.file)
    word.is_constant = True
    return word


def _number(pou: Pou) -> int:
    """The number of a function block, which is the same after an online change."""
    return crc32(pou.name.casefold().encode())


# ---- which calls go through a facade


def target(place: Place) -> Place:
    """Return the instance that a variable of an interface refers to, for a call."""
    kind = place.type
    return Target(Load(place), kind.to) if isinstance(kind, InterfaceType) else place


def general(place: Place) -> Pou | None:
    """Return the facade for a call of what is at a place; None for a direct call."""
    kind = place.type
    return kind.open.pou if isinstance(kind, BlockType) and kind.open is not None and _may_derive(place) else None


def through_facade(place: Place, made: Pou) -> Place:
    """Return the same instance as one of a facade."""
    assert made.type is not None
    return Target(place.pointer if isinstance(place, Target) else AddressOf(place, Elementary.DWORD), made.type)


def body(instance: Place, pou: Pou) -> tuple[Place, Pou]:
    """Return the instance and the body that a call runs."""
    made = general(instance)
    return (instance, pou) if made is None else (through_facade(instance, made), made.methods[BODY])


def _may_derive(place: Place) -> bool:
    """True if the instance at a place may be one of a function block that extends the type of the place."""
    if isinstance(place, Cell | Component):
        return place.variable is not None and place.variable.is_reference
    return isinstance(place, Target)


# ---- which instances a variable may refer to


def implements(project: Project, block: Pou, interface: InterfaceType) -> bool:
    source = project.sources.get(block)
    return source is not None and _has(project, inheritance.implemented(source), str(interface))


def extends(project: Project, one: InterfaceType, other: InterfaceType) -> bool:
    """True if an interface is or extends another one."""
    return _has(project, [str(one)], str(other))


def _has(project: Project, names: Sequence[str], wanted: str) -> bool:
    return any(
        project.key(interface.name) == project.key(wanted) for interface, _ in inheritance.closure(project, names)
    )


def is_or_derives(project: Project, kind: Type, above: Type) -> bool:
    """True for a function block, and for one that extends it."""
    return kind == above or derives(project, kind, above)


def derives(project: Project, kind: Type, above: Type) -> bool:
    """True if a function block extends another one, at whatever distance."""
    if not isinstance(kind, BlockType) or not isinstance(above, BlockType) or kind.pou is None or above.pou is None:
        return False
    source, base = project.sources.get(kind.pou), project.sources.get(above.pou)
    if source is None or base is None or source.line is None:
        return False
    return any(block is base.tree for block, _ in source.line.trees)


# ---- __QUERYINTERFACE


def query(project: Project, kind: InterfaceType) -> tuple[Pou, Sequence[Variable]]:
    """Return the function behind __QUERYINTERFACE for an interface: an address in, and a variable of the interface."""
    return _query(project, kind, lambda block: implements(project, block, kind))


def query_pointer(project: Project, kind: PointerType) -> tuple[Pou, Sequence[Variable]]:
    """Return the function behind __QUERYPOINTER: an address in, and a pointer to a function block."""
    return _query(project, kind, lambda block: block.type is not None and is_or_derives(project, block.type, kind.to))


def _query(
    project: Project, kind: InterfaceType | PointerType, is_one: Callable[[Pou], bool]
) -> tuple[Pou, Sequence[Variable]]:
    name = f"$query.{kind}"
    function = project.pous.get(project.key(name))
    if function is None:
        function = project.pous[project.key(name)] = Pou(PouKind.FUNCTION, name, "")
        address = Variable("address", Elementary.DWORD, Space.FRAME, Section.INPUT)
        into = Variable("into", kind, Space.FRAME, Section.IN_OUT)
        function.variables = {"address": address, "into": into}
        function.result = Variable(name, Elementary.BOOL, Space.FRAME, Section.OUTPUT)
        function.body = _query_body(project, kind, function.result, address, into, is_one)
    return function, list(function.variables.values())


def _query_body(
    project: Project,
    kind: InterfaceType | PointerType,
    result: Variable,
    address: Variable,
    into: Variable,
    is_one: Callable[[Pou], bool],
) -> list[AnyStatement]:
    given = Load(Cell(address, Elementary.DWORD))
    word = Load(Target(given, Elementary.UDINT))
    blocks = [pou for pou in project.sources if CLASS in pou.variables and is_one(pou)]
    tests: list[AnyStatement] = []
    for block in blocks:
        condition = Binary(Operator.EQ, word, Constant(_number(block), Elementary.UDINT), Elementary.BOOL)
        body = [Assign(Cell(into, kind), Convert(given, kind), line=0)]
        tests.append(If(condition, [*body, Assign(Cell(result, Elementary.BOOL), _TRUE, line=0)], line=0))
    is_something = Binary(Operator.NE, given, Constant(0, Elementary.DWORD), Elementary.BOOL)
    return [Assign(Cell(into, kind), Constant(0, kind), line=0), If(is_something, tests, line=0)]


_TRUE: Final = Constant(True, Elementary.BOOL)


# ---- the code of the facades


class Dispatchers:
    """The facades and their code: `begin` makes the blocks, and `finish` the bodies."""

    def __init__(self, project: Project) -> None:
        self._project = project
        self._families: list[tuple[Pou, list[Pou]]] = []
        """The facades, each with the function blocks whose instances it may stand for."""

    def begin(self) -> None:
        project = self._project
        blocks = [pou for pou in project.sources if pou.type is not None and CLASS in pou.variables]
        concrete = [pou for pou in blocks if not project.is_abstract(pou)]
        behind, below = self._relatives(concrete)
        for name, made in project.facades.items():
            self._families.append((made, behind.get(name, [])))
        for pou in blocks:
            if project.key(pou.name) in project.extended and pou.type is not None:
                self._families.append((self._above(pou, pou.type), below.get(id(project.sources[pou].tree), [])))

    def _relatives(self, concrete: Sequence[Pou]) -> tuple[dict[str, list[Pou]], dict[int, list[Pou]]]:
        """Return the function blocks behind each interface, and those that each tree of a function block is in."""
        project = self._project
        behind, below = dict[str, list[Pou]](), dict[int, list[Pou]]()
        for pou in concrete:
            source = project.sources[pou]
            implemented = [one for one, _ in inheritance.closure(project, inheritance.implemented(source))]
            line = [above for above, _ in source.line.trees] if source.line is not None else []
            for interface in implemented:
                behind.setdefault(project.key(interface.name), []).append(pou)
            for above in line:
                below.setdefault(id(above), []).append(pou)
            names = [one.name for one in implemented] + [one.name for one in line]
            pou.also = frozenset(map(str.casefold, names))
        return behind, below

    def _above(self, pou: Pou, kind: BlockType) -> Pou:
        """Make the facade of a function block and of those that extend it."""
        made = facade(f"{pou.name}@any", pou.file)
        kind.open = made.type
        for name, method in list(pou.methods.items()):
            if "@" not in name.removesuffix("@set"):
                self._copy(made, name, method)
        self._add(made, BODY, Pou(PouKind.FUNCTION, f"{made.name}.{BODY}", pou.file, owner=made))
        return made

    def _copy(self, owner: Pou, name: str, method: Pou) -> None:
        """Give a facade a method with the arguments and the result of another one."""
        made = Pou(PouKind.FUNCTION, f"{owner.name}.{name}", method.file, owner=owner, is_accessor=method.is_accessor)
        source, original = self._add(owner, name, made), self._project.sources[method]
        if method.result is not None:
            made.result = _copied(method.result)
        for variable in (*original.inputs, *original.outputs):
            limits, copy = copied(self._project, variable)
            made.variables |= {limit.name.casefold(): limit for limit in limits}
            made.variables[self._project.key(variable.name)] = copy
            (source.inputs if variable in original.inputs else source.outputs).append(copy)
        if method in self._project.guards:
            self._project.guards[made] = self._project.guards[method]

    def _add(self, owner: Pou, name: str, made: Pou) -> PouSource:
        owner.methods[name] = self._project.pous[f"{self._project.key(owner.name)}.{name}"] = made
        node = tree.Pou(PouKind.FUNCTION, name, None, (), tree.StBody(()))
        self._project.sources[made] = source = PouSource(made, node, is_library=False, outer=source_of(owner))
        return source

    def finish(self) -> None:
        for made, blocks in self._families:
            word = Load(Cell(made.variables[CLASS], Elementary.UDINT))
            for name, dispatcher in made.methods.items():
                for block in blocks:
                    number = Constant(_number(block), Elementary.UDINT)
                    condition = Binary(Operator.EQ, word, number, Elementary.BOOL)
                    calls = self._calls(name, dispatcher, block)
                    if calls:
                        dispatcher.body.append(If(condition, calls, line=0))

    def _calls(self, name: str, dispatcher: Pou, block: Pou) -> list[AnyStatement]:
        """Return the calls of what a dispatcher stands for in one function block: one, but every FB_exit above it."""
        if name == BODY:
            assert block.type is not None
            ok = Cell(enable.eno_of(dispatcher), Elementary.BOOL) if block.eno is not None else None
            return [CallBlock(This(block.type), block, enable=Enable(None, ok), line=0)]
        line = self._project.sources[block].line
        versions = line.versions.get(name, []) if line is not None else []
        return [self._call(method, dispatcher) for _, method in (versions if name == EXIT else versions[:1])]

    def _call(self, method: Pou, dispatcher: Pou) -> AnyStatement:
        own, theirs = self._project.sources[dispatcher], self._project.sources[method]
        inputs: list[tuple[Variable, Expression | Place]] = []
        outputs: tuple[tuple[Variable, Place, Expression], ...] = ()
        pairs = [*zip(theirs.inputs, own.inputs, strict=False), *zip(theirs.outputs, own.outputs, strict=False)]
        for wanted, given in pairs:
            cell = Cell(given, given.type)
            if wanted.section is Section.OUTPUT and not open_arrays.is_open(wanted):
                outputs = (*outputs, (wanted, cell, Load(Cell(wanted, wanted.type))))
            else:
                inputs += [(wanted, cell if given.is_reference else Load(cell)), *open_arrays.limits(wanted, cell)]
        kind = method.result.type if method.result is not None else Elementary.BOOL
        if method.eno is not None:
            eno = Cell(enable.eno_of(dispatcher), Elementary.BOOL)
            outputs = (*outputs, (method.eno, eno, Load(Cell(method.eno, Elementary.BOOL))))
        call = CallFunction(method, tuple(inputs), kind, outputs)
        if dispatcher.result is None or method.result is None:
            return Evaluate(call, line=0)
        return Assign(Cell(dispatcher.result, kind), call, line=0)


def copied(project: Project, variable: Variable) -> tuple[list[Variable], Variable]:
    """Return a copy of a parameter for another POU, with the limits in front of it that an ARRAY[*] has."""
    copy = _copied(variable)
    if variable in project.starts:
        project.starts[copy] = project.starts[variable]
    return open_arrays.renew_limits(copy), copy


def _copied(variable: Variable) -> Variable:
    copy = Variable(variable.name, variable.type, Space.FRAME, variable.section, variable.initial)
    copy.position, copy.file = variable.position, variable.file
    copy.is_constant, copy.is_fixed = variable.is_constant, variable.is_fixed
    return copy
