"""Faults that can be injected into the ring of a PAM, and their settings: those of every ring, and those of frames."""

from typing import Annotated, Final, Literal

from pydantic import Field

from fieldrig.faults import faults
from fieldrig.faults.faults import Repeated, Timed
from fieldrig_bus.ring.faults import Break, Off


class Distort(Repeated):
    """A segment damages the frames of a cycle: nodes behind it see a wrong CRC, and reports from before it are lost."""

    what: Literal["distort"]
    after: str = Field(description="the station that the segment leaves, or master")


class Halt(Timed):
    """The processor of a station has stopped.  Its optics pass the frames on, so the ring stays closed."""

    what: Literal["halt"]
    station: str


RingFault = Annotated[Break | Off | Distort | Halt, Field(discriminator="what")]
MODELS: Final = faults.models_of(RingFault)
