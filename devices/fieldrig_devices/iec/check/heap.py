"""`__NEW` and `__DELETE`: variables and instances that a program makes while it runs.

Source: the public descriptions of CODESYS V3 and TwinCAT 3.  `__NEW(T)` gives a pointer to a new T, `__NEW(T, n)` one
to n of them in a row, and `__NEW(Block(a := 1))` calls FB_init with these arguments; the result is 0 if there is no
memory.  `__DELETE(p)` calls FB_exit, gives the memory back, and sets the pointer to 0.

For each type there is a function that makes it: it takes the memory, and starts the instances as the declaration of a
variable does.
"""

from collections.abc import Callable, Iterator, Sequence
from typing import Final

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.check import dispatch, methods
from fieldrig_devices.iec.check.checker import Checker
from fieldrig_devices.iec.check.project import UNKNOWN, PouSource, Project
from fieldrig_devices.iec.check.startup import INIT
from fieldrig_devices.iec.check.texts import a, text
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.program import (
    Allocate,
    AnyStatement,
    Assign,
    Cell,
    Constant,
    Convert,
    Free,
    If,
    Load,
    Pou,
    Space,
    Variable,
)
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import BlockType, InterfaceType, PointerType, Type

NEW: Final = "__NEW"
DELETE: Final = "__DELETE"
COUNT: Final = "$count"
NUMBER: Final = "$number"
MADE: Final = "$made"
Caller = Callable[[Checker, tree.Call, int], list[AnyStatement]]
"""Checks a call as a statement."""


def call_of(checker: Checker, node: tree.Call) -> tuple[Pou, tree.Call] | None:
    """Return the function behind `__NEW(type)` or `__NEW(type, count)`, and its call; None after a message."""
    values = [argument.value for argument in node.arguments if argument.value is not None]
    if not 1 <= len(values) <= 2 or len(values) != len(node.arguments):
        checker.context.say(node, f"{NEW} with {len(node.arguments)} arguments", f"{NEW}(type) or {NEW}(type, count)")
        return None
    spec, project = spec_of(values[0]), checker.context.project
    if spec is None or project.specs is None:
        checker.context.say(values[0], f"{text(values[0])} is no type", "the name of a type")
        return None
    kind = project.specs.resolve(spec, checker.context)
    if kind is UNKNOWN:
        return None
    given = spec.arguments if isinstance(spec, tree.NamedType) else ()
    count = tree.Argument(values[1] if len(values) == 2 else _ONE, COUNT, position=node.position)
    call = tree.Call(tree.Name(NEW, position=node.position), (*given, count), position=node.position)
    return _maker(project, kind), call


_ONE: Final = tree.Literal(tree.LiteralKind.INTEGER, 1, "1")


def spec_of(node: tree.Expression) -> tree.TypeSpec | None:
    """Return the type that an argument of __NEW names, with the arguments of FB_init behind it."""
    if isinstance(node, tree.Unary) and node.operator == "POINTER TO":
        to = spec_of(node.operand)
        return tree.PointerSpec(to, position=node.position) if to is not None else None
    arguments: tuple[tree.Argument, ...] = ()
    named = node
    if isinstance(node, tree.Call):
        named, arguments = node.called, node.arguments
    name = _name(named)
    if name is None:
        return None
    if name.upper() in ("STRING", "WSTRING") and len(arguments) <= 1:
        length = arguments[0].value if arguments else None
        return tree.StringSpec(length, name.upper() == "WSTRING", position=node.position)
    return tree.NamedType(name, arguments, position=node.position)


def _name(node: tree.Expression) -> str | None:
    if isinstance(node, tree.Name):
        return node.text
    front = _name(node.of) if isinstance(node, tree.Member) else None
    return f"{front}.{node.name}" if front is not None and isinstance(node, tree.Member) else None


def _maker(project: Project, kind: Type) -> Pou:
    """Return the function that makes variables of a type."""
    if kind in project.makers:
        return project.makers[kind]
    name = f"{NEW}@{len(project.makers)}"
    function = project.makers[kind] = project.pous[project.key(name)] = Pou(PouKind.FUNCTION, name, "")
    result = function.result = Variable(MADE, PointerType(kind), Space.FRAME, Section.OUTPUT)
    count = Variable(COUNT, Elementary.UDINT, Space.FRAME, Section.INPUT)
    number = Variable(NUMBER, Elementary.UDINT, Space.FRAME, Section.TEMP)
    inputs = []
    for one in _constructor_inputs(project, kind):
        limits, copy = dispatch.copied(project, one)
        function.variables |= {project.key(limit.name): limit for limit in limits}
        function.variables[project.key(copy.name)] = copy
        inputs.append(copy)
    function.variables |= {project.key(one.name): one for one in (count, number)}
    names = {project.key(one.name): one for one in (*inputs, count, number, result)}
    body = tree.StBody(tuple(_start(project, kind, inputs)))
    node = tree.Pou(PouKind.FUNCTION, name, None, (), body)
    project.sources[function] = PouSource(function, node, False, names, [*inputs, count])
    memory = Allocate(kind, Convert(Load(Cell(count, count.type)), Elementary.DWORD), result.type)
    project.preludes[function] = [Assign(Cell(result, result.type), memory, line=0)]
    return function


def _constructor_inputs(project: Project, kind: Type) -> list[Variable]:
    """Return the inputs of FB_init behind the two that every FB_init has."""
    method = kind.pou.methods.get(INIT) if isinstance(kind, BlockType) and kind.pou is not None else None
    return project.sources[method].inputs[2:] if method is not None else []


def _start(project: Project, kind: Type, inputs: Sequence[Variable]) -> Iterator[tree.AnyStatement]:
    """Yield the statements that start the instances in new memory, one after the other."""
    assert project.startup is not None
    element = tree.Index(tree.Name(MADE), (tree.Name(NUMBER),))
    given = tuple(tree.Argument(tree.Name(one.name), one.name) for one in inputs)
    statements = tuple(project.startup.of_new(element, kind, tree.NamedType("", given)))
    if not statements:
        return
    step = tree.Assign(tree.Name(NUMBER), tree.Binary("+", tree.Name(NUMBER), _ONE))
    is_left = tree.Binary("<", tree.Name(NUMBER), tree.Name(COUNT))
    is_made = tree.Binary("<>", tree.Name(MADE), tree.Literal(tree.LiteralKind.INTEGER, 0, "0"))
    yield tree.While(tree.Binary("AND", is_made, is_left), (*statements, step))


def deleted(checker: Checker, node: tree.Call, line: int, call: Caller) -> list[AnyStatement]:
    """Check `__DELETE(pointer)`."""
    given = node.arguments[0].value if len(node.arguments) == 1 else None
    if given is None:
        checker.context.say(node, f"{DELETE} with {len(node.arguments)} arguments", f"{DELETE}(pointer)")
        return []
    pointer = methods.pointer_to_this(checker.context, given)
    if pointer is not None:
        assert isinstance(pointer.type, PointerType)
        return [*_exits(checker, given, pointer.type, line, call), Free(Convert(pointer, Elementary.DWORD), line=line)]
    place = checker.target(given)
    if place is None:
        return []
    kind = place.type
    if not isinstance(kind, PointerType) or kind.is_reference:
        checker.context.say(given, f"{text(given)} is {a(kind)}", "a pointer that __NEW has given, or an interface")
        return []
    address = Convert(Load(place), Elementary.DWORD)
    exits = [] if isinstance(kind, InterfaceType) else _exits(checker, given, kind, line, call)
    nothing = Assign(place, Constant(0, kind), line=line)
    return [*exits, Free(address, line=line), nothing]


def _exits(
    checker: Checker, given: tree.Expression, kind: PointerType, line: int, caller: Caller
) -> list[AnyStatement]:
    """Return the calls of FB_exit of an instance, if there is one, from the block itself up to its bases."""
    block = kind.to.pou if isinstance(kind.to, BlockType) else None
    if block is None:
        return []
    names = sorted(name for name in block.methods if name.partition("@")[0] == dispatch.EXIT)
    if not names:
        return []
    instance = tree.Dereference(given, position=given.position)
    no_copy = tree.Argument(tree.Literal(tree.LiteralKind.BOOL, False, "FALSE"))
    is_there = tree.Binary("<>", given, tree.Literal(tree.LiteralKind.INTEGER, 0, "0"), position=given.position)
    made: list[AnyStatement] = []
    condition = checker.expression(is_there)
    if condition is None:
        return []
    for name in names:
        method = block.methods[name]
        arguments = (no_copy,) if checker.context.project.sources[method].inputs else ()
        call = tree.Call(tree.Member(instance, name, position=given.position), arguments, position=given.position)
        made += caller(checker, call, line)
    return [If(condition, made, line=line)]
