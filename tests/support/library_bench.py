"""A program that is called at given times, for tests of the standard library and of the language's page."""

from iec_program import IecBench

from fieldrig_devices.iec.dialect import EPAS_4, Dialect
from fieldrig_devices.iec.tasks.task import WorkState
from fieldrig_devices.iec.types import Type, Value

BUDGET_NS = 100_000_000


class Bench(IecBench):
    """The program PLC_PRG of a source text."""

    def __init__(self, text: str, dialect: Dialect = EPAS_4) -> None:
        super().__init__(text, dialect)

    def call(self, at_ms: int) -> None:
        """Run the program once, at this time since the start of the controller."""
        assert self.run(at_ms) is WorkState.ENDED, self.thread.fault

    def call_after(self, wait_ms: int) -> None:
        """Run the program once, this time after the last call."""
        self.call(self.host.ms + wait_ms)

    def run(self, at_ms: int) -> WorkState:
        """Run the program once, and return how that ended."""
        self.host.ms = at_ms
        self.thread.start()
        self.thread.run(BUDGET_NS)
        return self.thread.state

    def read(self, path: str) -> Value:
        return self.runtime.read(self.runtime.find(path))

    def write(self, path: str, value: Value) -> None:
        self.runtime.write(self.runtime.find(path), value)

    def type_of(self, path: str) -> Type:
        return self.runtime.find(path).type
