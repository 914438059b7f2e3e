"""Faults of a fibre ring: what they may be told.

A fault says where (a segment, by the station that it leaves; or a station), what, when and how long (`start_ms`,
`duration_ms`) and how often (`count`, `probability`).  Healing is clearing the fault, or its end.
"""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal, cast

from pydantic import Field, model_validator

from fieldrig import faults
from fieldrig.faults import Timed
from fieldrig_bus.ring.breaks import Break, Off


class _Struck(Timed):
    count: int | None = Field(default=None, ge=1, description="telegrams that it strikes; left out: any number")
    probability: float = Field(default=1.0, gt=0, le=1, description="of striking a telegram that fits")


class Distort(_Struck):
    """Telegrams come with a wrong FCS, and so not at all."""

    what: Literal["distort"]
    after: str | None = Field(default=None, description="a segment: MST and MDT behind it, ATs from before it")
    station: str | None = Field(default=None, description="one station: what it hears, and its AT")
    telegram: Literal["mst", "mdt", "at"] | None = Field(default=None, description="left out: any")

    @model_validator(mode="after")
    def _check_place(self) -> "Distort":
        if (self.after is None) == (self.station is None):
            raise ValueError("where: give either after, a segment, or station")
        return self


class Late(_Struck):
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
