"""A function under test: a call returns its result."""

from collections.abc import Mapping
from typing import Any

from fieldrig.errors import ArgumentError
from fieldrig.text.nearest import closest
from fieldrig_devices.iec.bench.python_values import Placed, at, read, write
from fieldrig_devices.iec.bench.under_test import UnderTest
from fieldrig_devices.iec.bench.wrappers import BLOCK, Call, Wrapper
from fieldrig_devices.iec.symbols import Symbol


class Function:
    """Takes values in the order of the declaration, or by name; an input that is not given has its start value."""

    def __init__(self, program: UnderTest, wrapper: Wrapper, call: Call, instance: int | None = None) -> None:
        """`instance` is the address of that whose method it is, if the wrapper has a pointer to it."""
        self._program, self._wrapper, self._call, self._instance = program, wrapper, call, instance
        self._name, self._inputs = call.shown, list(call.inputs)
        self.outputs: Mapping[str, Any] = {}
        """VAR_OUTPUT and VAR_IN_OUT after the last call, by name."""

    def __call__(self, *values: Any, **named: Any) -> Any:
        program, call, given = self._program, self._call, self._given(values, named)
        for name, value in given.items():
            program.fit(call, name, value)
        pou, base = program.of_wrapper(self._wrapper)
        if self._instance is not None:
            program.cells[program.variable(self._wrapper, BLOCK)[1]] = self._instance
        for name, own in call.inputs.items():
            if name in call.pointers:
                instance = given.pop(name) if isinstance(given.get(name), Placed) else None
                write(program.runtime, self._symbol(call.pointers[name], name), instance)
            if name in given:
                write(program.runtime, self._symbol(own, name), given[name])
            elif name not in call.opens:
                program.runtime.restart(pou.variables[program.dialect.key(own)], base)
        program.runner(self._wrapper, call.action)()
        self.outputs = {name: read(program.runtime, self._symbol(own, name)) for name, own in call.outputs.items()}
        return read(program.runtime, self._symbol(call.result, "result")) if call.result else None

    def _symbol(self, own: str, name: str) -> Symbol:
        return at(*self._program.variable(self._wrapper, own), f"{self._name}.{name}")

    def _given(self, values: tuple[Any, ...], named: Mapping[str, Any]) -> dict[str, Any]:
        """Return the arguments by their declared names."""
        if len(values) > len(self._inputs):
            expected = ", ".join(self._inputs) or "none"
            count = f"{len(self._inputs)} argument{'s' if len(self._inputs) != 1 else ''}"
            raise ArgumentError(f"{self._name} takes {count}", f"expected {expected}")
        given = dict(zip(self._inputs, values, strict=False))
        for name, value in named.items():
            known = next((one for one in self._inputs if one.casefold() == name.casefold()), None)
            if known in given:
                raise ArgumentError(f"{self._name}.{known} is given twice", "expected it by its place or by its name")
            if known is None:
                raise ArgumentError(f"{self._name} has no further input {name!r}", closest(name, self._inputs))
            given[known] = value
        return given
