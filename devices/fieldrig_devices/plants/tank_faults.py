"""The faults of a tank: in the vessel, its outlet, its level sensor, and its two switches."""

from collections.abc import Mapping
from typing import Annotated, Any, Final, Literal

from pydantic import Field

from fieldrig.faults.faults import Timed, models_of


class Leak(Timed):
    """The vessel has a hole beside the outlet."""

    what: Literal["leak"]
    area_m2: float = Field(
        default=1e-4, gt=0, le=1e3, description="of the hole in the bottom; water leaves it as it does the outlet"
    )


class BlockedOutlet(Timed):
    """The outlet is blocked, whatever the opening of its valve."""

    what: Literal["blocked_outlet"]


class StuckSensor(Timed):
    """The level sensor sticks, and shows the same level all the time."""

    what: Literal["stuck_sensor"]
    level_m: float | None = Field(
        default=None, ge=0, le=1e6, description="level that it shows; left out: the one of its last change"
    )


class StuckSwitch(Timed):
    """A level switch sticks."""

    what: Literal["stuck_switch"]
    switch: Literal["high", "low"] = Field(description="which one")
    shows: bool | None = Field(default=None, description="state of its contact; left out: the one that it has")


MODELS: Final[Mapping[str, type[Any]]] = models_of(
    Annotated[Leak | BlockedOutlet | StuckSensor | StuckSwitch, Field(discriminator="what")]
)
