"""The base of all settings of plants, whose numbers are physical quantities in SI units."""

from typing import Final, Self

from pydantic import ConfigDict, model_validator

from fieldrig.settings import Settings

SMALLEST: Final = 1e-12
LARGEST: Final = 1e12


class PlantSettings(Settings):
    model_config = ConfigDict(allow_inf_nan=False)

    @model_validator(mode="after")
    def _are_physical(self) -> Self:
        """Refuse numbers that cannot be computed with, such as a motor of 1e300 N m."""
        for name, value in self:
            if isinstance(value, float) and value and not SMALLEST <= abs(value) <= LARGEST:
                raise ValueError(f"{name} cannot be {value:g}; expected {SMALLEST:g} to {LARGEST:g}")
        return self
