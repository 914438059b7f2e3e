"""Faults that can be injected into a SERCOS ring, and their settings: those of every ring, and those of telegrams."""

from typing import Annotated, Final, Literal

from pydantic import Field, model_validator

from fieldrig.faults import faults
from fieldrig.faults.faults import Repeated
from fieldrig_bus.ring.faults import Break, Off


class Distort(Repeated):
    """Telegrams have a wrong FCS, so they do not arrive."""

    what: Literal["distort"]
    after: str | None = Field(
        default=None, description="a segment: it concerns MST and MDT behind it, and ATs from before it"
    )
    station: str | None = Field(default=None, description="one station: it concerns what the station hears, and its AT")
    telegram: Literal["mst", "mdt", "at"] | None = Field(default=None, description="the telegram; left out: any")

    @model_validator(mode="after")
    def _check_place(self) -> "Distort":
        if (self.after is None) == (self.station is None):
            raise ValueError("where: expected either after (a segment) or station")
        return self


class Late(Repeated):
    """A station's AT is not ready when its slot comes."""

    what: Literal["late"]
    station: str


RingFault = Annotated[Break | Off | Distort | Late, Field(discriminator="what")]
MODELS: Final = faults.models_of(RingFault)
