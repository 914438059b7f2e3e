"""Faults that can be injected into a SERCOS ring, and their settings.

A fault says where (a segment, by the station that it leaves; or a station), what, when and for how long (`start_ms`,
`duration_ms`) and how often (`count`, `probability`).  It ends when it is cleared, or after its duration.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, cast

from pydantic import Field, model_validator

from fieldrig import faults
from fieldrig.faults import Timed
from fieldrig_bus.ring.breaks import Break, Off


class _TelegramFault(Timed):
    count: int | None = Field(default=None, ge=1, description="number of telegrams; left out: any number")
    probability: float = Field(default=1.0, gt=0, le=1, description="probability for each telegram")


class Distort(_TelegramFault):
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


class Late(_TelegramFault):
    """A station's AT is not ready when its slot comes."""

    what: Literal["late"]
    station: str


RingFault = Annotated[Break | Off | Distort | Late, Field(discriminator="what")]
MODELS: Final = faults.models_of(RingFault)


def place_of(fault: RingFault) -> tuple[str, str]:
    """The key that says where, and the station that it names."""
    match fault:
        case Break(after=str(after)) | Distort(after=str(after)):
            return "after", after
        case Off(station=str(station)) | Late(station=str(station)) | Distort(station=str(station)):
            return "station", station
    raise AssertionError(f"{fault} has no place")


def fault_of(given: Mapping[str, Any]) -> RingFault:
    """Return the settings of a fault of a ring.

    ValueError: its first line says what is wrong, further lines say what was expected.
    """
    return cast(RingFault, faults.fault_of(given, MODELS))
