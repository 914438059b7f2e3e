"""An IEC program that runs by itself: a host with nothing but memory, and the values of variables by name."""

from collections.abc import Sequence

import pytest

from fieldrig.clock import VirtualClock
from fieldrig_devices.iec.compiler import Compiled, compile_project
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.host import Library, Pending
from fieldrig_devices.iec.program import ConfiguredObject
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.thread import Thread
from fieldrig_devices.iec.types import Value
from fieldrig_devices.languages.mistakes import CompileError
from fieldrig_devices.languages.source_file import SourceFile

ENOUGH_NS = 1_000_000_000
MAIN = "PLC_PRG"


class PlainHost(StandaloneHost):
    """A controller with areas, a clock that the test sets, and parameters in a table."""

    def __init__(self, libraries: Sequence[Library] = (), objects: Sequence[ConfiguredObject] = ()) -> None:
        super().__init__(VirtualClock())
        self.libraries = libraries
        self.objects = {configured.name.lower(): configured for configured in objects}
        self.object_types = {configured.type.name.lower(): configured.type for configured in objects}
        self.written: list[int] = []
        """Bytes of %Q in the order in which they were written."""
        self.ms = 0
        self.parameters: dict[int, Value] = {}
        self.pending: list[tuple[int, Value | None, Pending]] = []
        """Slow accesses that have not been answered: address, value for a write, and the answer."""

    def read(self, address: int) -> Value:
        return self.parameters[address]

    def write(self, address: int, value: Value) -> None:
        if address not in self.parameters:
            raise KeyError(address)
        self.parameters[address] = value

    def read_slowly(self, address: int) -> Pending:
        return self._ask(address, None)

    def write_slowly(self, address: int, value: Value) -> Pending:
        return self._ask(address, value)

    def _ask(self, address: int, value: Value | None) -> Pending:
        answer = Pending()
        self.pending.append((address, value, answer))
        return answer

    def on_output(self, byte: int) -> None:
        self.written.append(byte)

    def now_ms(self) -> int:
        return self.ms


class IecBench:
    """A compiled program and one thread for its main program."""

    def __init__(
        self,
        text: str,
        dialect: Dialect = EPAS_4,
        host: PlainHost | None = None,
        main: str = MAIN,
        name: str = "main.st",
        others: Sequence[SourceFile] = (),
    ) -> None:
        """`name` is the name of the file, whose ending says what is in it; `others` are further files."""
        self._name, self._others = name, others
        self.host = host or PlainHost()
        self.dialect = dialect
        self.compiled = self.compile(text)
        self.runtime = Runtime(self.compiled, self.host)
        self.main = main
        self.thread: Thread = self.runtime.thread(self.compiled.program.pous[dialect.key(main)])

    def compile(self, text: str, previous: Compiled | None = None) -> Compiled:
        return compile_project(
            [SourceFile(self._name, text), *self._others],
            self.host,
            self.dialect,
            previous=previous.layout if previous is not None else None,
        )

    def cycle(self, cycles: int = 1, budget_ns: int = ENOUGH_NS) -> int:
        """Run whole cycles in slices of a budget; return the processor time that they took."""
        used = 0
        for _ in range(cycles):
            self.thread.start()
            while self.thread.state is WorkState.READY:
                used += budget_ns - self.thread.run(budget_ns)
        return used

    def __getitem__(self, path: str) -> Value:
        """Return a variable of the main program, or a global one."""
        symbol = self.runtime.symbols.find(f"{self.main}.{path}") or self.runtime.find(path)
        return self.runtime.read(symbol)

    def __setitem__(self, path: str, value: Value) -> None:
        symbol = self.runtime.symbols.find(f"{self.main}.{path}") or self.runtime.find(path)
        self.runtime.write(symbol, value)

    def values(self) -> dict[str, Value]:
        """Return all values of the main program by path."""
        runtime = self.runtime
        found = runtime.symbols.values(runtime.find(self.main))
        return {symbol.path: runtime.read(symbol) for symbol in found if len(symbol.steps) == 1}


def program(declarations: str, body: str) -> str:
    return f"PROGRAM PLC_PRG\nVAR\n{declarations}\nEND_VAR\n{body}\nEND_PROGRAM\n"


def refused(text: str, dialect: Dialect) -> list[str]:
    """Return the messages about a program that does not compile."""
    with pytest.raises(CompileError) as found:
        IecBench(text, dialect)
    return [str(mistake) for mistake in found.value.mistakes]
