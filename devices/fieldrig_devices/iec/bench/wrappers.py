"""The callers of blocks and functions under test: a hidden block for each, with variables for their arguments."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final
from zlib import crc32

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.dialect import EDITION_3
from fieldrig_devices.iec.parser import parse_body
from fieldrig_devices.iec.testing.extension import CaseExtension, begin_unit

BLOCK: Final = "tested"
"""The instance under test."""
RESULT: Final = "result of function"
_FILE: Final = "fieldrig.program"
_IMPLICIT: Final = frozenset({"fb_init", "fb_exit", "fb_reinit"})
_ARGUMENTS: Final = (tree.Section.INPUT, tree.Section.IN_OUT, tree.Section.OUTPUT)


@dataclass(frozen=True, slots=True)
class Wrapper:
    """One call under test; `number` tells several instances of one block apart."""

    name: str
    number: int
    init: tuple[tuple[str, str], ...] = ()
    """The arguments of FB_init, by name, as constants of the language."""

    @property
    def pou(self) -> str:
        # Names count to their 32nd character in EPAS-4 (PD-350), so that of the block would not tell them apart.
        return f"BENCH {crc32(repr((self.name.casefold(), self.init)).encode()):08x} {self.number}"

    @property
    def instance(self) -> str:
        return f"{self.pou} instance"


@dataclass(frozen=True, slots=True)
class Call:
    """One thing that a wrapper can call: the block or function itself, a method, or a part of a property."""

    shown: str
    inputs: Mapping[str, str]
    """The names of the arguments, each with the variable of the wrapper that gives it."""
    outputs: Mapping[str, str]
    result: str = ""
    """The variable with the result; empty if there is none."""
    action: str = ""
    """The action of the wrapper that makes the call; empty for its body."""
    pointers: Mapping[str, str] = field(default_factory=dict)
    """The VAR_IN_OUT that are instances, each with the pointer of the wrapper to the instance that is passed."""


@dataclass(slots=True)
class Calls:
    """All that a wrapper can call, by names without upper case."""

    own: Call
    methods: dict[str, Call] = field(default_factory=dict)
    getters: dict[str, Call] = field(default_factory=dict)
    setters: dict[str, Call] = field(default_factory=dict)


class BenchExtension(CaseExtension):
    """Adds the wrappers to the program."""

    def __init__(self, wrappers: Sequence[Wrapper], mocked: Sequence[str]) -> None:
        super().__init__(mocked)
        self._wrappers = wrappers
        self.calls: dict[Wrapper, Calls] = {}

    def units(self, units: Sequence[tree.Unit]) -> Sequence[tree.Unit]:
        known = {one.name.casefold(): one for unit in units for one in unit.declarations if isinstance(one, tree.Pou)}
        made: list[tree.Declaration] = []
        for wrapper in self._wrappers:
            declared = _Declared(wrapper, known)
            made += declared.declarations()
            self.calls[wrapper] = declared.calls
        plain = [replace(unit, tests=()) for unit in units]  # tests of the same file do not matter here
        self._files.add(_FILE)
        return [*plain, tree.Unit(_FILE, tuple(made)), begin_unit()]


class _Declared:
    """The declarations of one wrapper."""

    def __init__(self, wrapper: Wrapper, known: Mapping[str, tree.Pou]) -> None:
        self._wrapper, self._pou = wrapper, known.get(wrapper.name.casefold())
        self._line, self._known = _line_of(self._pou, known), known
        self._variables: dict[str, tree.Variable] = {}
        self._actions: list[tree.Action] = []
        self._pointers: dict[str, str] = {}
        """The pointers of the call that is made now."""
        self._body = self._of_function() if self._is_function else self._of_block()

    @property
    def _is_function(self) -> bool:
        return self._pou is not None and self._pou.kind is tree.PouKind.FUNCTION

    def declarations(self) -> list[tree.Declaration]:
        wrapper, blocks = self._wrapper, (tree.Variables(tree.Section.LOCAL, tuple(self._variables.values())),)
        kind, body = tree.PouKind.FUNCTION_BLOCK, tree.StBody(self._body)
        made = tree.Pou(kind, wrapper.pou, None, blocks, body, tuple(self._actions))
        instance = tree.Variable(wrapper.instance, tree.NamedType(wrapper.pou))
        return [made, tree.Variables(tree.Section.GLOBAL, (instance,))]

    def _add(self, name: str, spec: tree.TypeSpec, initial: tree.Initial | None = None) -> str:
        self._variables.setdefault(name.casefold(), tree.Variable(name, spec, initial))
        return name

    def _arguments(
        self, blocks: Iterable[tree.Variables], sections: Collection[tree.Section], prefix: str = ""
    ) -> tuple[list[tree.Argument], dict[str, str], dict[str, str]]:
        """Give each parameter a variable; return the arguments of the call, and the variables of inputs and outputs."""
        arguments, inputs, outputs = list[tree.Argument](), dict[str, str](), dict[str, str]()
        for block in (block for block in blocks if block.section in sections):
            for variable in block.variables:
                if variable.name in inputs or variable.name in outputs:
                    continue
                own = self._add(f"{prefix}{variable.name}", variable.type, variable.initial)
                is_output = block.section is tree.Section.OUTPUT
                passed: tree.Expression = tree.Name(own)
                if block.section is tree.Section.IN_OUT and self._is_block(variable.type):
                    pointer = self._pointers[variable.name] = self._add(f"TO {own}", tree.PointerSpec(variable.type))
                    passed = tree.Dereference(tree.Name(pointer))
                arguments.append(tree.Argument(passed, variable.name, is_output=is_output))
                if not is_output:
                    inputs[variable.name] = own
                if block.section is not tree.Section.INPUT:
                    outputs[variable.name] = own
        return arguments, inputs, outputs

    def _is_block(self, spec: tree.TypeSpec) -> bool:
        pou = self._known.get(spec.name.casefold()) if isinstance(spec, tree.NamedType) else None
        return pou is not None and pou.kind.has_instances

    def _with_own_instances(
        self, statement: tree.AnyStatement, inputs: Mapping[str, str]
    ) -> tuple[tuple[tree.AnyStatement, ...], dict[str, str]]:
        """Return a call behind lines that let unset pointers refer to instances of the wrapper, and the pointers."""
        pointers, self._pointers = self._pointers, {}
        made: list[tree.AnyStatement] = []
        for name, pointer in pointers.items():
            own = tree.Call(tree.Name("ADR"), (tree.Argument(tree.Name(inputs[name])),))
            nothing = tree.Binary("=", tree.Name(pointer), tree.Literal(tree.LiteralKind.INTEGER, 0))
            made.append(tree.If((tree.Branch(nothing, (tree.Assign(tree.Name(pointer), own),)),)))
        return (*made, statement), pointers

    def _called(self, call: tree.Call, result: tree.TypeSpec | None, name: str) -> tuple[tree.AnyStatement, str]:
        """Return the statement of a call, and the variable with its result."""
        if result is None:
            return tree.CallStatement(call), ""
        return tree.Assign(tree.Name(self._add(name, result)), call), name

    def _of_function(self) -> tuple[tree.AnyStatement, ...]:
        pou = self._pou
        assert pou is not None, "a function is known"
        arguments, inputs, outputs = self._arguments(pou.blocks, _ARGUMENTS)
        statement, result = self._called(tree.Call(tree.Name(pou.name), tuple(arguments)), pou.result, RESULT)
        statements, pointers = self._with_own_instances(statement, inputs)
        self.calls = Calls(Call(pou.name, inputs, outputs, result, pointers=pointers))
        return statements

    def _of_block(self) -> tuple[tree.AnyStatement, ...]:
        blocks = [block for one in self._line for block in one.blocks]
        arguments, inputs, outputs = self._arguments(blocks, (tree.Section.IN_OUT,))
        init = tuple(tree.Argument(_constant(text), name) for name, text in self._wrapper.init)
        self._add(BLOCK, tree.NamedType(self._wrapper.name, init))
        call = tree.CallStatement(tree.Call(tree.Name(BLOCK), tuple(arguments)))
        statements, pointers = self._with_own_instances(call, inputs)
        self.calls = Calls(Call(self._wrapper.name, inputs, outputs, pointers=pointers))
        for method in (method for one in self._line for method in one.methods):
            if method.name.casefold() not in _IMPLICIT:
                self._method(method)
        return statements

    def _method(self, method: tree.Method) -> None:
        calls, name = self.calls, method.name.casefold()
        known = {"GET": calls.getters, "SET": calls.setters}.get(method.accessor, calls.methods)
        if name in known:
            return  # the one of a block above is hidden by it
        action = f"{method.accessor or 'METHOD'} {method.name}"
        member = tree.Member(tree.Name(BLOCK), method.name)
        statement: tree.AnyStatement | None = None
        inputs, outputs, result = dict[str, str](), dict[str, str](), ""
        if method.accessor == "GET" and method.result is not None:
            result = self._add(f"{action} result", method.result)
            statement = tree.Assign(tree.Name(result), member)
        elif method.accessor and method.result is not None:
            inputs = {method.name: self._add(f"{action} value", method.result)}
            statement = tree.Assign(member, tree.Name(inputs[method.name]))
        elif not method.accessor:
            arguments, inputs, outputs = self._arguments(method.blocks, _ARGUMENTS, f"{action} ")
            call = tree.Call(member, tuple(arguments))
            statement, result = self._called(call, method.result, f"{action} result")
        if statement is not None:
            statements, pointers = self._with_own_instances(statement, inputs)
            self._actions.append(tree.Action(action, tree.StBody(statements)))
            known[name] = Call(f"{self._wrapper.name}.{method.name}", inputs, outputs, result, action, pointers)


def _line_of(pou: tree.Pou | None, known: Mapping[str, tree.Pou]) -> list[tree.Pou]:
    """Return a block and those that it extends, as far as the project has them."""
    line: list[tree.Pou] = []
    while pou is not None and pou not in line:
        line.append(pou)
        pou = known.get(pou.extends.casefold()) if pou.extends else None
    return line


def _constant(text: str) -> tree.Expression:
    """Return the tree of a constant."""
    body, mistakes = parse_body(f"x := {text};", _FILE, "ST", EDITION_3)
    assert not mistakes, f"{text} is made of a value of Python"
    assert isinstance(body, tree.StBody)
    [statement] = body.statements
    assert isinstance(statement, tree.Assign)
    return statement.value
