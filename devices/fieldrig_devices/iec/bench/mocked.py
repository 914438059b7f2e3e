"""Python functions in the place of functions and blocks of a program."""

from collections.abc import Callable, Iterable, Mapping
from inspect import signature
from types import MappingProxyType
from typing import Any

from fieldrig.errors import ArgumentError
from fieldrig_devices.iec.bench.instance import Instance
from fieldrig_devices.iec.bench.owner import Owner
from fieldrig_devices.iec.bench.python_values import at, read, write
from fieldrig_devices.iec.bench.views import Structure, structure
from fieldrig_devices.iec.program import Pou, Space
from fieldrig_devices.iec.symbols import Symbol
from fieldrig_devices.iec.testing.mocks import Mock
from fieldrig_devices.iec.tree import PouKind, Section
from fieldrig_devices.iec.types import OpenArrayType


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

    def _wants_outputs(self) -> bool:
        try:
            return "outputs" in signature(self._call).parameters
        except ValueError:  # a function in C that does not tell its parameters
            return False

    def _outputs(self, pou: Pou, base: int) -> Structure:
        """Return VAR_OUTPUT and VAR_IN_OUT of a function, for the mock to read and to write."""
        found = [
            Symbol(one.name, one.name, one.type, steps=(base + one.offset, *((0,) if one.is_reference else ())))
            for one in pou.variables.values()
            if one.section in (Section.OUTPUT, Section.IN_OUT)
            and one.name[:1] != "$"
            and one.space is not Space.GLOBAL
            and not isinstance(one.type, OpenArrayType)
        ]
        return structure(self._bench.runtime, f"outputs of {pou.name}", found)

    def _check(self, arguments: Iterable[Any], words: str, named: Mapping[str, Any] = MappingProxyType({})) -> None:
        """ArgumentError if the Python function does not take these arguments."""
        try:
            signature(self._call).bind(*arguments, **named)
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
        outputs = {"outputs": self._outputs(pou, base)} if self._wants_outputs() else {}
        self._check(inputs.values(), f"its inputs: {', '.join(inputs)}", outputs)
        value = self._call(*inputs.values(), **outputs)
        if pou.result is not None:
            write(runtime, at(pou.result.type, base + pou.result.offset, f"the result of {pou.name}"), value)
