"""A program of IEC 61131-3 under test in Python (`fieldrig.program`)."""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from fieldrig.errors import ArgumentError, RigError
from fieldrig.programs import ProgramBench, checked_duration
from fieldrig_devices.iec.bench.function import Function
from fieldrig_devices.iec.bench.instance import Block, told
from fieldrig_devices.iec.bench.mocked import PythonMock
from fieldrig_devices.iec.bench.owner import Functions
from fieldrig_devices.iec.bench.python_values import cell_of, literal, write
from fieldrig_devices.iec.bench.strategies import values_of
from fieldrig_devices.iec.bench.under_test import UnderTest
from fieldrig_devices.iec.bench.views import view
from fieldrig_devices.iec.bench.wrappers import BLOCK, Wrapper
from fieldrig_devices.iec.program import Pou
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.tree import PouKind
from fieldrig_devices.iec.types import ArrayType, BlockType
from fieldrig_devices.languages.source_file import SourceFile


class IecBench(ProgramBench):
    def __init__(self, files: Sequence[SourceFile], dialect: str, resource: str) -> None:
        """ConfigError with every mistake of the program."""
        self._program = UnderTest(files, dialect, resource)
        self._begin()
        self._program.on_renewed, self._program.on_method = self._bind_all, self._methods_at

    def _begin(self) -> None:
        self._used: dict[str, int] = {}
        """How many instances of each block this test has."""
        self._blocks: list[tuple[Wrapper | None, Block]] = []
        self._read: dict[str, None] = {}
        """The paths of the variables that this test has read, in this order."""

    @property
    def now_ns(self) -> int:
        return self._program.now_ns

    @property
    def events(self) -> Sequence[str]:
        return self._program.events

    # ---- time

    def start(self) -> None:
        if not self._program.scheduler.tasks:
            raise RigError("the program has no tasks to start", "call a block, or write CONFIGURATION with a TASK")
        self._program.start()

    def stop(self) -> None:
        self._program.scheduler.stop()

    def reset(self) -> None:
        self._program.reset()
        self._begin()

    def _begin_again(self, *, with_tasks: bool) -> None:
        self._program.begin_again()
        self._bind_all()
        for _, block in self._blocks:
            block._forget()
        if with_tasks:
            self.start()

    def advance(self, duration_ns: int) -> None:
        before = len(self.events)
        self._program.clock.advance_to(self.now_ns + checked_duration(duration_ns))
        self._program.raise_from_mock()
        faults = [event for event in self.events[before:] if "suspended" in event]
        if faults:
            raise RigError(faults[0], "`events` has all that has happened")

    def next_ns(self) -> int | None:
        return self._program.clock.next_ns()

    # ---- variables

    def get(self, path: str) -> Any:
        symbol = self._symbol(path)
        self._read[symbol.path] = None
        return view(self._program.runtime, symbol)

    def set(self, path: str, value: Any) -> None:
        write(self._program.runtime, self._symbol(path), value)

    def _symbol(self, path: str) -> Symbol:
        symbols = self._program.runtime.symbols
        symbol = symbols.find(path) if isinstance(path, str) else None
        if symbol is None:
            raise ArgumentError(f"the program has no variable {path!r}", self._meant(path))
        return symbol

    def _meant(self, path: object) -> str:
        """Return a hint for a path that no variable has."""
        symbols = self._program.runtime.symbols
        if not isinstance(path, str):
            return 'expected a path such as "Main.level"'
        whole = symbols.find(path.rpartition("[")[0]) if path.endswith("]") else None
        if whole is not None and isinstance(whole.type, ArrayType):
            return f"expected an index from {whole.type.low} to {whole.type.high}"
        near = symbols.closest(path)
        return f"did you mean {near}?" if near else 'expected a path such as "Main.level"'

    def values(self, path: str) -> Any:
        symbol = self._symbol(path)
        return values_of(symbol.type, symbol.path)

    def _inputs_of(self, block: Any) -> Sequence[str]:
        return self._instance(block)._inputs()

    def _values_of(self, block: Any, name: str) -> Any:
        return self.values(name) if block is None else values_of(*self._instance(block)._kind_of(name))

    @staticmethod
    def _instance(block: Any) -> Block:
        if not isinstance(block, Block):
            raise ArgumentError(f"{block!r} is no instance under test", 'expected one of block("Lift")')
        return block

    def force(self, path: str, value: Any) -> None:
        symbol = self._symbol(path)
        if not symbol.is_value:
            raise ArgumentError(f"{symbol.path} is a {symbol.type}", "expected one of its parts")
        cell = cell_of(self._program.runtime, symbol.type, value, symbol.path)
        try:
            self._program.runtime.force(symbol, cell)
        except ValueError as wrong:
            raise ArgumentError(*str(wrong).partition("; ")[::2]) from wrong

    def release(self, path: str) -> None:
        self._program.runtime.force(self._symbol(path), None)

    # ---- blocks and functions

    def block(self, name: str, **init: Any) -> Block:
        pou = self._plain(name)
        if pou.kind is PouKind.FUNCTION or pou.type is None:
            raise ArgumentError(f"{pou.name} is a function", f'expected function("{pou.name}")')
        if init and pou.instance is not None:
            raise ArgumentError(f"{pou.name} is a program, which has no FB_init", f'expected block("{pou.name}")')
        wrapper: Wrapper | None = None
        if pou.instance is None:
            self._used[pou.name] = number = self._used.get(pou.name, 0) + 1
            wrapper = Wrapper(pou.name, number, tuple((key, literal(value)) for key, value in init.items()))
            self._program.add(wrapper)
        block = Block(self._program, pou.name)
        self._bind(wrapper, block, pou.name)
        self._blocks.append((wrapper, block))
        return block

    def _plain(self, name: str) -> Pou:
        """Return a unit that is no method."""
        pou = self._program.pou(name)
        if pou.owner is not None:
            block, _, method = pou.name.partition(".")
            raise ArgumentError(f"{pou.name} is a method", f'expected block("{block}").{method}(...)')
        return pou

    def function(self, name: str) -> Callable[..., Any]:
        pou = self._plain(name)
        if pou.kind is not PouKind.FUNCTION:
            raise ArgumentError(f"{pou.name} is no function", f'expected block("{pou.name}")')
        wrapper = Wrapper(pou.name, 1)
        self._program.add(wrapper)
        return Function(self._program, wrapper, self._program.calls[wrapper].own)

    def _bind_all(self) -> None:
        """Give all instances the code and the places of the program as it is now."""
        for wrapper, block in self._blocks:
            self._bind(wrapper, block, block._path)

    def _bind(self, wrapper: Wrapper | None, block: Block, name: str) -> None:
        program, pou = self._program, self._program.pou(name)
        assert pou.type is not None, "a block has a type"
        if wrapper is None:
            assert pou.instance is not None, "a program has an instance"
            block._bind(pou.type, pou.instance.offset, program.runner_of(program.runtime.thread(pou)))
            return
        calls = program.calls[wrapper]
        _, address = program.variable(wrapper, BLOCK)
        in_outs = {name.lower(): program.variable(wrapper, own) for name, own in calls.own.inputs.items()}
        pointers = {name.lower(): program.variable(wrapper, own)[1] for name, own in calls.own.pointers.items()}
        opens = {name.lower(): partial(program.fit, calls.own, name) for name in calls.own.opens}
        block._bind(pou.type, address, program.runner(wrapper), in_outs, self._functions(wrapper), pointers, opens)

    def _functions(self, wrapper: Wrapper, instance: int | None = None) -> Functions:
        """Return what `Call`s of methods and properties a wrapper has, as functions."""
        program, calls = self._program, self._program.calls[wrapper]
        return {
            part: {name: Function(program, wrapper, call, instance) for name, call in known.items()}
            for part, known in (("", calls.methods), ("GET", calls.getters), ("SET", calls.setters))
        }

    def _methods_at(self, kind: BlockType, address: int) -> Functions:
        wrapper = Wrapper(kind.name, 0, is_pointer=True)
        self._program.add(wrapper)
        return self._functions(wrapper, address)

    def mock(self, name: str, call: Callable[..., Any] | None = None, *, returns: Any = None) -> PythonMock:
        if call is not None and not callable(call):
            raise ArgumentError(f"{call!r} cannot take the place of {name}", "expected a function")
        return self._program.mock(name, call if call is not None else lambda *inputs: returns)

    def _told_of_values(self) -> list[str]:
        return [*self._told_of_tasks(), *(line for _, block in self._blocks for line in block._told())]

    def _told_of_tasks(self) -> list[str]:
        """Return a line for each variable that the test has read while tasks ran."""
        lines = []
        for path in self._read:
            symbol = self._program.runtime.symbols.find(path)
            if symbol is None or not symbol.is_value or len(symbol.steps) > 1 or symbol.location is not None:
                continue
            changes = self._program.changes.of(symbol.steps[0])
            if changes:
                lines.append(told(path, symbol.type, changes, self._program.declared(path)))
        return lines
