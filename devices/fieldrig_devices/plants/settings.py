"""What all settings of plants have in common: their numbers are physical quantities in SI."""

from typing import Final, Self

from pydantic import ConfigDict, model_validator

from fieldrig.settings import Settings

SMALLEST: Final = 1e-12
LARGEST: Final = 1e12


class PlantSettings(Settings):
    model_config = ConfigDict(allow_inf_nan=False)

    @model_validator(mode="after")
    def _are_of_this_world(self) -> Self:
        """What can be computed with: a motor of 1e300 N m would be through with its first turn before it was told."""
        for name, value in self:
            if isinstance(value, float) and value and not SMALLEST <= abs(value) <= LARGEST:
                raise ValueError(f"{name} can't be {value:g}: {SMALLEST:g} to {LARGEST:g} would be right")
        return self
