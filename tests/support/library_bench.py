"""A program that is called at given times, for tests of the standard library and of the language's page."""

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.iec.compiler import SourceFile, compile_project
from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.runtime import Runtime
from fieldrig_devices.iec.standalone import StandaloneHost
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Type, Value

BUDGET_NS = 100_000_000


class Bench:
    """The program PLC_PRG of a source text."""

    def __init__(self, text: str, dialect: Dialect = EPAS_4) -> None:
        self._clock = VirtualClock()
        host = StandaloneHost(self._clock)
        compiled = compile_project([SourceFile("bench.st", text)], host, dialect)
        self._runtime = Runtime(compiled, host)
        self._thread = self._runtime.thread(compiled.program.pous["plc_prg"])

    def call(self, at_ms: int) -> None:
        """Run the program once, at this time since the start of the controller."""
        assert self.run(at_ms) is WorkState.ENDED, self._thread.fault

    def call_after(self, wait_ms: int) -> None:
        """Run the program once, this time after the last call."""
        self.call(self._clock.now_ns() // MS + wait_ms)

    def run(self, at_ms: int) -> WorkState:
        """Run the program once, and return how that ended."""
        self._clock.advance_to(at_ms * MS)
        self._thread.start()
        self._thread.run(BUDGET_NS)
        return self._thread.state

    def read(self, path: str) -> Value:
        return self._runtime.read(self._runtime.find(path))

    def write(self, path: str, value: Value) -> None:
        self._runtime.write(self._runtime.find(path), value)

    def type_of(self, path: str) -> Type:
        return self._runtime.find(path).type
