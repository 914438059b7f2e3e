"""Pins of function blocks, and a block as its callers see it: a program, or a map of registers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Final

PinValue = int


class Side(Enum):
    INPUT = "VAR_INPUT"
    OUTPUT = "VAR_OUTPUT"


WIDTHS: Final[Mapping[str, int]] = {
    "BOOL": 1,
    "BYTE": 8,
    "DWORD": 32,
    "PTO_REF": 8,
    "PTO_DIRECTION": 8,
    "PTO_PARAMETER_TYPE": 8,
    "PTOPWM_ERR_TYPE": 8,
}
"""Bits of the values that a pin of each IEC type can have.  All are unsigned."""


@dataclass(frozen=True, slots=True)
class Pin:
    name: str
    side: Side
    type: str
    """A key of `WIDTHS`: an elementary type or one of the library."""
    default: PinValue = 0
    about: str = ""


@dataclass(frozen=True, slots=True)
class BlockType:
    """A kind of function block.  Its pins are in the order of the manual's figure; names ignore case, as in IEC."""

    name: str
    pins: tuple[Pin, ...]

    @property
    def inputs(self) -> Sequence[Pin]:
        return [pin for pin in self.pins if pin.side is Side.INPUT]

    @property
    def outputs(self) -> Sequence[Pin]:
        return [pin for pin in self.pins if pin.side is Side.OUTPUT]

    def pin(self, name: str) -> Pin:
        """Return the pin of this name in any case.  KeyError if there is none."""
        for pin in self.pins:
            if pin.name.lower() == name.lower():
                return pin
        raise KeyError(name)


class Block:
    """An instance of a function block.

    A caller sets `inputs`, calls `call` once in each MAST cycle and reads `outputs`.  A pin that a caller leaves alone
    keeps its value (SCU-078).  Both mappings have the names of `type` in the manual's spelling.
    """

    type: BlockType

    def __init__(self) -> None:
        self.inputs: dict[str, PinValue] = {pin.name: pin.default for pin in self.type.inputs}
        self.outputs: dict[str, PinValue] = {pin.name: pin.default for pin in self.type.outputs}

    def call(self, now_ns: int) -> None:
        """Evaluate the block at this instant.  Instants never go back."""
        raise NotImplementedError

    def run(self, now_ns: int, *inputs: PinValue) -> tuple[PinValue, ...]:
        """Set all inputs in their order, call the block, and return all outputs in their order."""
        self.inputs.update(zip(self.inputs, inputs, strict=True))
        self.call(now_ns)
        return tuple(self.outputs.values())
