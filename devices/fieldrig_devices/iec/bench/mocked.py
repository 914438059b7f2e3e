"""Python functions in the place of functions and blocks of a program."""

from collections.abc import Callable, Iterable
from inspect import signature
from typing import Any

from fieldrig.errors import ArgumentError
from fieldrig_devices.iec.bench.instance import Instance
from fieldrig_devices.iec.bench.owner import Owner
from fieldrig_devices.iec.bench.python_values import at, read, write
from fieldrig_devices.iec.program import Space
from fieldrig_devices.iec.testing.mocks import Mock
from fieldrig_devices.iec.tree import PouKind, Section


class PythonMock:
    """A Python function that is called instead of a function or a block."""

    def __init__(self, bench: Owner, name: str, call: Callable[..., Any]) -> None:
        self._bench, self.name, self._call = bench, name, call
        self.arguments: list[tuple[Any, ...]] = []
        """The inputs of each call, in their order."""
        self.is_on = True

    @property
    def calls(self) -> int:
        """The number of calls so far."""
        return len(self.arguments)

    def stop(self) -> None:
        """Let the code of the program run again."""
        self.is_on = False

    def _check(self, arguments: Iterable[Any], words: str) -> None:
        """ArgumentError if the Python function does not take these arguments."""
        try:
            signature(self._call).bind(*arguments)
        except TypeError as wrong:
            raise ArgumentError(f"the mock of {self.name} cannot be called: {wrong}", f"it gets {words}") from None
        except ValueError:  # a function in C that does not tell its parameters
            return

    def answer(self, mock: Mock, address: int) -> None:
        """Answer one call, with its variables at an address."""
        pou, runtime = mock.pou, self._bench.runtime
        base = address - mock.first.offset
        inputs = {
            one.name: read(runtime, at(one.type, base + one.offset, one.name))
            for one in pou.variables.values()
            if one.section is Section.INPUT and one.name[:1] != "$" and one.space is not Space.GLOBAL
        }
        self.arguments.append(tuple(inputs.values()))
        if pou.kind is not PouKind.FUNCTION:
            assert pou.type is not None, "a block has a type"
            instance = Instance(self._bench, pou.name, pou.type, base)
            self._check([instance], "its instance")
            self._call(instance)
            return
        self._check(inputs.values(), f"its inputs: {', '.join(inputs)}")
        value = self._call(*inputs.values())
        if pou.result is not None:
            write(runtime, at(pou.result.type, base + pou.result.offset, f"the result of {pou.name}"), value)
