"""Terminals of the controller that belong to an axis: named by a face's settings, and its inputs as bits of 60FDh."""

from collections.abc import Iterable, Mapping

from pydantic import Field

from fieldrig.settings import Settings
from fieldrig_devices.max4.configuration.tree import ObjectTree, Parameter
from fieldrig_devices.max4.core import Controller


class SwitchSettings(Settings):
    """Limit switches of an axis: digital inputs of the controller, by their symbolic names."""

    negative_limit: str = Field(default="", description="input: negative limit switch (60FDh bit 0)")
    positive_limit: str = Field(default="", description="input: positive limit switch (bit 1)")

    @property
    def switches(self) -> dict[int, str]:
        """By their bits."""
        named = {0: self.negative_limit, 1: self.positive_limit}
        return {bit: symbol for bit, symbol in named.items() if symbol}


class AxisInputs:
    def __init__(self, parameters: Mapping[int, Parameter]) -> None:
        """By their bits."""
        self._parameters = parameters

    @property
    def inputs(self) -> int:
        if not self._parameters:
            return 0
        return sum(1 << bit for bit, parameter in self._parameters.items() if parameter.value)


def terminals_in(tree: ObjectTree, symbols: Mapping[int, str]) -> dict[int, Parameter]:
    """Those that the present configuration has."""
    found = {bit: _terminal(tree, symbol) for bit, symbol in symbols.items()}
    return {bit: parameter for bit, parameter in found.items() if parameter is not None}


def check_terminals(controller: Controller, key: str, named: Mapping[str, Iterable[str]]) -> None:
    """ValueError, with what would be right, for an axis or a symbolic name that is not there."""
    for name, symbols in named.items():
        if name not in controller.axes:
            there = ", ".join(controller.axes) or "none"
            raise ValueError(f"{key}: there is no axis {name}; there are {there}")
        for symbol in symbols:
            if _terminal(controller.tree, symbol) is None:
                raise ValueError(f"{key} of {name}: there is no input or output {symbol}")


def _terminal(tree: ObjectTree, symbol: str) -> Parameter | None:
    try:
        return tree.parameter(f"{symbol}.Value")
    except KeyError:
        return None
