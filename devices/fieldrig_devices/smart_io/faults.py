"""The faults that a Smart-IO node takes.  `board.py` says what each of them does."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed, models_of

Address = Annotated[int, Field(ge=101, le=1612, description="module times 100 plus position, such as 203")]


class ShortCircuit(Timed):
    """An output is connected to 0 V: while the node drives it high, it is off, and its group is reported."""

    what: Literal["short_circuit"]
    address: Address


class BrokenWire(Timed):
    """The wire of an input is broken, so its level is low; at a counter input, all pulses are lost."""

    what: Literal["broken_wire"]
    address: Address


class Overtemperature(Timed):
    """The heat sink of a module, or the ambient air, is too hot."""

    what: Literal["overtemperature"]
    module: int | None = Field(default=None, ge=1, le=16, description="left out: the ambient air")


class DamagedFrames(Timed):
    """Frames arrive with a wrong checksum, or of an unknown type."""

    what: Literal["damaged_frames"]
    of: Literal["crc", "type"] = "crc"


class FullFifo(Timed):
    """A FIFO of the node is full: E 1 to E 8."""

    what: Literal["full_fifo"]
    number: int = Field(ge=1, le=8, description="number of the FIFO; 6 receives the commands of the PAM")


class LowBattery(Timed):
    """The node loses its configuration when the fault begins: F 4."""

    what: Literal["low_battery"]


SmartIoFault = Annotated[
    ShortCircuit | BrokenWire | Overtemperature | DamagedFrames | FullFifo | LowBattery,
    Field(discriminator="what"),
]
MODELS: Final[Mapping[str, type[Any]]] = models_of(SmartIoFault)
