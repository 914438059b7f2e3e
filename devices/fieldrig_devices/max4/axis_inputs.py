"""Terminals of the controller that belong to an axis by the settings of a face, with its inputs as bits of 60FDh."""

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
        """Names of the inputs by bit."""
        named = {0: self.negative_limit, 1: self.positive_limit}
        return {bit: symbol for bit, symbol in named.items() if symbol}


class AxisInputs:
    """The digital inputs of an axis, as in 60FDh."""

    def __init__(self, parameters: Mapping[int, Parameter]) -> None:
        """`parameters` are the values of the inputs by bit."""
        self._parameters = parameters

    @property
    def inputs(self) -> int:
        if not self._parameters:
            return 0
        return sum(1 << bit for bit, parameter in self._parameters.items() if parameter.value)


def terminals_in(tree: ObjectTree, symbols: Mapping[int, str]) -> dict[int, Parameter]:
    """The terminals among `symbols` that the present configuration has, by bit."""
    parameters = {bit: _terminal(tree, symbol) for bit, symbol in symbols.items()}
    return {bit: parameter for bit, parameter in parameters.items() if parameter is not None}


def check_terminals(controller: Controller, key: str, named: Mapping[str, Iterable[str]]) -> None:
    """Check the names under `key`.  ValueError for an axis or a terminal that does not exist."""
    for name, symbols in named.items():
        if name not in controller.axes:
            there = ", ".join(controller.axes) or "none"
            raise ValueError(f"{key}: expected the name of an axis ({there}), got {name}")
        for symbol in symbols:
            if _terminal(controller.tree, symbol) is None:
                raise ValueError(f"{key} of {name}: expected the name of an input or output, got {symbol}")


def _terminal(tree: ObjectTree, symbol: str) -> Parameter | None:
    try:
        return tree.parameter(f"{symbol}.Value")
    except KeyError:
        return None
