"""The callers of blocks and functions under test: a hidden block for each, with variables for their arguments."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final
from zlib import crc32

from fieldrig_devices.iec import tree
from fieldrig_devices.iec.bench.open_arguments import Shape, closed, is_any, is_open
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
    is_pointer: bool = False
    """True for one that calls methods of the instance that its pointer leads to, and has none of its own."""

    @property
    def pou(self) -> str:
        # Names count to their 32nd character in EPAS-4 (PD-350), so that of the block would not tell them apart.
        return f"BENCH {crc32(repr((self.name.casefold(), self.init, self.is_pointer)).encode()):08x} {self.number}"

    @property
    def instance(self) -> str:
        return f"{self.pou} instance"

    def open(self, own: str) -> str:
        """Return the global variable of an argument whose type changes with its value, so that nothing else moves."""
        return f"{self.pou} {own}"


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
    opens: Mapping[str, tuple[str, tree.TypeSpec]] = field(default_factory=dict)
    """The arguments that are an ARRAY[*] or an ANY, each with its global variable and its declared type."""


@dataclass(slots=True)
class Calls:
    """All that a wrapper can call, by names without upper case."""

    own: Call
    methods: dict[str, Call] = field(default_factory=dict)
    getters: dict[str, Call] = field(default_factory=dict)
    setters: dict[str, Call] = field(default_factory=dict)


class BenchExtension(CaseExtension):
    """Adds the wrappers to the program."""

    def __init__(self, wrappers: Sequence[Wrapper], mocked: Sequence[str], shapes: Mapping[str, Shape]) -> None:
        """`shapes` are those of the arguments whose type comes with their value, by `Wrapper.open`."""
        super().__init__(mocked)
        self._wrappers, self._shapes = wrappers, shapes
        self.calls: dict[Wrapper, Calls] = {}

    def units(self, units: Sequence[tree.Unit]) -> Sequence[tree.Unit]:
        known = {one.name.casefold(): one for unit in units for one in unit.declarations if isinstance(one, tree.Pou)}
        made: list[tree.Declaration] = []
        for wrapper in self._wrappers:
            declared = _Declared(wrapper, known, self._shapes)
            made += declared.declarations()
            self.calls[wrapper] = declared.calls
        plain = [replace(unit, tests=()) for unit in units]  # tests of the same file do not matter here
        self._files.add(_FILE)
        return [*plain, tree.Unit(_FILE, tuple(made)), begin_unit()]


class _Declared:
    """The declarations of one wrapper."""

    def __init__(self, wrapper: Wrapper, known: Mapping[str, tree.Pou], shapes: Mapping[str, Shape]) -> None:
        self._wrapper, self._pou, self._shapes = wrapper, known.get(wrapper.name.casefold()), shapes
        self._line, self._known = _line_of(self._pou, known), known
        self._variables: dict[str, tree.Variable] = {}
        self._globals: dict[str, tree.Variable] = {}
        self._actions: list[tree.Action] = []
        self._pointers: dict[str, str] = {}
        """The pointers of the call that is made now."""
        self._tested: tree.Expression = tree.Name(BLOCK)
        self._body = self._of_function() if self._is_function else self._of_block()

    @property
    def _is_function(self) -> bool:
        return self._pou is not None and self._pou.kind is tree.PouKind.FUNCTION

    def declarations(self) -> list[tree.Declaration]:
        wrapper, blocks = self._wrapper, (tree.Variables(tree.Section.LOCAL, tuple(self._variables.values())),)
        kind, body = tree.PouKind.FUNCTION_BLOCK, tree.StBody(self._body)
        made = tree.Pou(kind, wrapper.pou, None, blocks, body, tuple(self._actions))
        instance = tree.Variable(wrapper.instance, tree.NamedType(wrapper.pou))
        return [made, tree.Variables(tree.Section.GLOBAL, (instance, *self._globals.values()))]

    def _add(self, name: str, spec: tree.TypeSpec, initial: tree.Initial | None = None) -> str:
        self._variables.setdefault(name.casefold(), tree.Variable(name, spec, initial))
        return name

    def _given(
        self, blocks: Iterable[tree.Variables], sections: Collection[tree.Section], prefix: str = ""
    ) -> "_Given":
        """Give each parameter in these sections a variable."""
        given = _Given()
        for block in (block for block in blocks if block.section in sections):
            for variable in block.variables:
                if variable.name not in given.inputs and variable.name not in given.outputs:
                    self._give(given, variable, block.section, prefix)
        return given

    def _give(self, given: "_Given", variable: tree.Variable, section: tree.Section, prefix: str) -> None:
        name = variable.name
        if is_open(variable.type):
            own = self._add_open(f"{prefix}{name}", variable.type)
            given.opens[name] = own, variable.type
        else:
            own = self._add(f"{prefix}{name}", variable.type, variable.initial)
        is_output = section is tree.Section.OUTPUT
        passed: tree.Expression = tree.Name(own)
        if section is tree.Section.IN_OUT and self._is_block(variable.type):
            pointer = given.pointers[name] = self._add(f"TO {own}", tree.PointerSpec(variable.type))
            passed = tree.Dereference(tree.Name(pointer))
        given.arguments.append(tree.Argument(passed, name, is_output=is_output))
        if not is_output:
            given.inputs[name] = own
        if section is not tree.Section.INPUT:
            given.outputs[name] = own

    def _add_open(self, name: str, spec: tree.TypeSpec) -> str:
        own = self._wrapper.open(name)
        self._globals[own.casefold()] = tree.Variable(own, closed(spec, self._shapes.get(own)))
        return own

    def _is_block(self, spec: tree.TypeSpec) -> bool:
        pou = self._known.get(spec.name.casefold()) if isinstance(spec, tree.NamedType) else None
        return pou is not None and pou.kind.has_instances

    def _called(self, call: tree.Call, result: tree.TypeSpec | None, name: str) -> tuple[tree.AnyStatement, str]:
        """Return the statement of a call, and the variable with its result."""
        if result is None:
            return tree.CallStatement(call), ""
        return tree.Assign(tree.Name(self._add(name, result)), call), name

    def _of_function(self) -> tuple[tree.AnyStatement, ...]:
        pou = self._pou
        assert pou is not None, "a function is known"
        given = self._given(pou.blocks, _ARGUMENTS)
        statement, result = self._called(tree.Call(tree.Name(pou.name), tuple(given.arguments)), pou.result, RESULT)
        self.calls = Calls(given.call(pou.name, result))
        return given.before(statement)

    def _of_block(self) -> tuple[tree.AnyStatement, ...]:
        if self._wrapper.is_pointer:
            return self._of_pointer()
        blocks = [block for one in self._line for block in one.blocks]
        given = self._given(blocks, (tree.Section.IN_OUT,))
        self._give_any(given, blocks)
        init = tuple(tree.Argument(_constant(text), name) for name, text in self._wrapper.init)
        self._add(BLOCK, tree.NamedType(self._wrapper.name, init))
        self._methods(given.call(self._wrapper.name))
        return given.before(tree.CallStatement(tree.Call(tree.Name(BLOCK), tuple(given.arguments))))

    def _of_pointer(self) -> tuple[tree.AnyStatement, ...]:
        self._add(BLOCK, tree.PointerSpec(tree.NamedType(self._wrapper.name)))
        self._tested = tree.Dereference(tree.Name(BLOCK))
        self._methods(_Given().call(self._wrapper.name))
        return ()

    def _methods(self, own: Call) -> None:
        self.calls = Calls(own)
        for method in (method for one in self._line for method in one.methods):
            if method.name.casefold() not in _IMPLICIT:
                self._method(method)

    def _give_any(self, given: "_Given", blocks: Iterable[tree.Variables]) -> None:
        """Pass a variable to each ANY of the block that the test has given; the others stay empty."""
        for variable in (one for block in blocks if block.section is tree.Section.INPUT for one in block.variables):
            if is_any(variable.type):
                own = self._wrapper.open(variable.name)
                given.opens[variable.name] = own, variable.type
                if own in self._shapes:
                    self._give(given, variable, tree.Section.INPUT, "")

    def _method(self, method: tree.Method) -> None:
        calls, name = self.calls, method.name.casefold()
        known = {"GET": calls.getters, "SET": calls.setters}.get(method.accessor, calls.methods)
        if name in known:
            return  # the one of a block above is hidden by it
        action = f"{method.accessor or 'METHOD'} {method.name}"
        member = tree.Member(self._tested, method.name)
        statement: tree.AnyStatement | None = None
        given, result = _Given(), ""
        if method.accessor == "GET" and method.result is not None:
            result = self._add(f"{action} result", method.result)
            statement = tree.Assign(tree.Name(result), member)
        elif method.accessor and method.result is not None:
            given.inputs[method.name] = self._add(f"{action} value", method.result)
            statement = tree.Assign(member, tree.Name(given.inputs[method.name]))
        elif not method.accessor:
            given = self._given(method.blocks, _ARGUMENTS, f"{action} ")
            call = tree.Call(member, tuple(given.arguments))
            statement, result = self._called(call, method.result, f"{action} result")
        if statement is not None:
            self._actions.append(tree.Action(action, tree.StBody(given.before(statement))))
            known[name] = given.call(f"{self._wrapper.name}.{method.name}", result, action)


@dataclass(slots=True)
class _Given:
    """The arguments of one call, and the names of the variables behind them (`Call` has the meanings)."""

    arguments: list[tree.Argument] = field(default_factory=list)
    inputs: dict[str, str] = field(default_factory=dict)
    outputs: dict[str, str] = field(default_factory=dict)
    pointers: dict[str, str] = field(default_factory=dict)
    opens: dict[str, tuple[str, tree.TypeSpec]] = field(default_factory=dict)

    def before(self, statement: tree.AnyStatement) -> tuple[tree.AnyStatement, ...]:
        """Return a call behind lines that let unset pointers refer to instances of the wrapper."""
        made: list[tree.AnyStatement] = []
        for name, pointer in self.pointers.items():
            own = tree.Call(tree.Name("ADR"), (tree.Argument(tree.Name(self.inputs[name])),))
            nothing = tree.Binary("=", tree.Name(pointer), tree.Literal(tree.LiteralKind.INTEGER, 0))
            made.append(tree.If((tree.Branch(nothing, (tree.Assign(tree.Name(pointer), own),)),)))
        return (*made, statement)

    def call(self, shown: str, result: str = "", action: str = "") -> Call:
        return Call(shown, self.inputs, self.outputs, result, action, self.pointers, self.opens)


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
