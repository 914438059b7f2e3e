"""What a rig file says about the MAx-4 as Modbus server."""

from typing import Final, Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_bus.modbus.identification import Identification
from fieldrig_devices.max4.axis_inputs import SwitchSettings
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.registers.table import WordOrder

NO_LIMITS: Final = (-0x8000_0000, 0x7FFF_FFFF)
"""Software limits that are none, as in 607Dh."""


class AxisLimits(SwitchSettings):
    """What ends the way of an axis; a switch that isn't named is that of `can_axes`, if there is one."""

    min_position: int = Field(
        default=NO_LIMITS[0], ge=NO_LIMITS[0], le=NO_LIMITS[1], description="start value of the register, in units"
    )
    max_position: int = Field(
        default=NO_LIMITS[1], ge=NO_LIMITS[0], le=NO_LIMITS[1], description="start value of the register, in units"
    )

    @property
    def software(self) -> tuple[int, int]:
        return self.min_position, self.max_position

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.min_position >= self.max_position:
            raise ValueError(f"min_position {self.min_position}: below max_position would be right")
        return self


class ModbusFaceSettings(Settings):
    unit_id: int = Field(default=1, ge=1, le=247, description="unit id (slave address)")
    turnaround_ms: float = Field(default=2.0, ge=0, le=60_000, description="from a request to its response; 0: at once")
    word_order: WordOrder = Field(default="big", description="big: the high word of a value first")
    refusal: Literal["server_failure", "illegal_value"] = Field(
        default="server_failure", description="a value or command that is refused: exception 04, or 03"
    )
    increments_per_unit: int = Field(default=1000, ge=1, le=1_000_000, description="what a unit of length is")
    units: dict[Symbol, int] = Field(default_factory=dict, description="the same for single axes")
    limits: dict[Symbol, AxisLimits] = Field(
        default_factory=dict, description="limit switches and software limits, by the symbolic names of the axes"
    )
    watchdog_ms: int = Field(
        default=0, ge=0, description="axes stop that clients have set in motion when none asks for so long; 0: never"
    )
    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="MAx-4", product_name="PacController"),
        description="function 43/14",
    )
