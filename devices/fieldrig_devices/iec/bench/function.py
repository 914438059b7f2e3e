"""A function under test: a call returns its result."""

from collections.abc import Mapping
from typing import Any

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.python_values import Placed, at, read, write
from fieldrig_devices.iec.bench.under_test import UnderTest
from fieldrig_devices.iec.bench.wrappers import Call, Wrapper
from fieldrig_devices.iec.program import Pou


class Function:
    """Takes values in the order of the declaration, or by name; an input that is not given has its start value."""

    def __init__(self, program: UnderTest, wrapper: Wrapper, call: Call) -> None:
        self._program, self._wrapper, self._call = program, wrapper, call
        self._name, self._inputs = call.shown, list(call.inputs)
        self.outputs: Mapping[str, Any] = {}
        """VAR_OUTPUT and VAR_IN_OUT after the last call, by name."""

    def __call__(self, *values: Any, **named: Any) -> Any:
        program, call, given = self._program, self._call, self._given(values, named)
        pou, base = program.of_wrapper(self._wrapper)
        for name, own in call.inputs.items():
            variable = pou.variables[program.dialect.key(own)]
            if name in call.pointers:
                pointer = pou.variables[program.dialect.key(call.pointers[name])]
                instance = given.pop(name) if isinstance(given.get(name), Placed) else None
                place = at(pointer.type, base + pointer.offset, f"{self._name}.{name}")
                write(program.runtime, place, instance)
            if name not in given:
                program.runtime.restart(variable, base)
                continue
            write(program.runtime, at(variable.type, base + variable.offset, f"{self._name}.{name}"), given[name])
        program.runner(self._wrapper, call.action)()
        self.outputs = {name: self._read(pou, own, base) for name, own in call.outputs.items()}
        return self._read(pou, call.result, base) if call.result else None

    def _read(self, pou: Pou, name: str, base: int) -> Any:
        variable = pou.variables[self._program.dialect.key(name)]
        return read(self._program.runtime, at(variable.type, base + variable.offset, name))

    def _given(self, values: tuple[Any, ...], named: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments by their declared names."""
        if len(values) > len(self._inputs):
            expected = ", ".join(self._inputs) or "none"
            count = f"{len(self._inputs)} argument{'s' if len(self._inputs) != 1 else ''}"
            raise ArgumentError(f"{self._name} takes {count}", f"expected {expected}")
        given = dict(zip(self._inputs, values, strict=False))
        for name, value in named.items():
            known = next((one for one in self._inputs if one.casefold() == name.casefold()), None)
            if known is None or known in given:
                raise ArgumentError(f"{self._name} has no further input {name!r}", closest(name, self._inputs))
            given[known] = value
        return given
