"""A function under test: a call returns its result."""

from collections.abc import Mapping
from typing import Any

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.python_values import cells_of, to_python
from fieldrig_devices.iec.bench.under_test import UnderTest
from fieldrig_devices.iec.bench.wrappers import RESULT, Wrapper
from fieldrig_devices.iec.program import Pou, Variable
from fieldrig_devices.iec.tree import Section


class Function:
    """Takes values in the order of the declaration, or by name; an input that is not given has its start value."""

    def __init__(self, program: UnderTest, pou: Pou, wrapper: Wrapper) -> None:
        self._program, self._name, self._wrapper = program, pou.name, wrapper
        own = [one for one in pou.variables.values() if one.name[:1] != "$"]
        self._inputs = [one.name for one in own if one.section in (Section.INPUT, Section.IN_OUT)]
        self._outputs = [one.name for one in own if one.section in (Section.OUTPUT, Section.IN_OUT)]
        self.outputs: Mapping[str, Any] = {}
        """VAR_OUTPUT and VAR_IN_OUT after the last call, by name."""

    def __call__(self, *values: Any, **named: Any) -> Any:
        program, given = self._program, self._given(values, named)
        pou, base = program.of_wrapper(self._wrapper)
        for name in self._inputs:
            variable = pou.variables[program.dialect.key(name)]
            if name not in given:
                program.runtime.restart(variable, base)
                continue
            path, at = f"{self._name}.{name}", base + variable.offset
            for address, cell in list(cells_of(variable.type, given[name], path, at)):
                program.cells[address] = cell
        program.runner(self._wrapper)()
        self.outputs = {name: self._read(pou.variables[program.dialect.key(name)], base) for name in self._outputs}
        result = pou.variables.get(program.dialect.key(RESULT))
        return None if result is None else self._read(result, base)

    def _read(self, variable: Variable, base: int) -> Any:
        return to_python(variable.type, self._program.cells, base + variable.offset)

    def _given(self, values: tuple[Any, ...], named: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments by their declared names."""
        if len(values) > len(self._inputs):
            expected = ", ".join(self._inputs) or "none"
            raise ArgumentError(f"{self._name} takes {len(self._inputs)} arguments", f"expected {expected}")
        given = dict(zip(self._inputs, values, strict=False))
        for name, value in named.items():
            known = next((one for one in self._inputs if one.casefold() == name.casefold()), None)
            if known is None or known in given:
                raise ArgumentError(f"{self._name} has no further input {name!r}", closest(name, self._inputs))
            given[known] = value
        return given
