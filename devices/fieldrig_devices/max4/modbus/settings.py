"""Settings of the MAx-4 as a Modbus server."""

from typing import Self

from pydantic import Field, model_validator

from fieldrig_bus.modbus.identification import Identification
from fieldrig_devices.cia402.objects import NO_POSITION_LIMITS
from fieldrig_devices.max4.axis_inputs import SwitchSettings
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.modbus.port import PortSettings
from fieldrig_devices.registers.form import WordOrder
from fieldrig_devices.registers.value import Refusal

_LOWEST, _HIGHEST = NO_POSITION_LIMITS


class AxisLimits(SwitchSettings):
    """Limits of an axis.  A switch that is not named here is that of `can_axes`, if there is one."""

    min_position: int = Field(
        default=_LOWEST, ge=_LOWEST, le=_HIGHEST, description="start value of the register, in units"
    )
    max_position: int = Field(
        default=_HIGHEST, ge=_LOWEST, le=_HIGHEST, description="start value of the register, in units"
    )

    @property
    def software(self) -> tuple[int, int]:
        return self.min_position, self.max_position

    @model_validator(mode="after")
    def _fits_together(self) -> Self:
        if self.min_position >= self.max_position:
            raise ValueError(
                f"min_position: expected less than max_position {self.max_position}, got {self.min_position}"
            )
        return self


class ModbusFaceSettings(PortSettings):
    word_order: WordOrder = Field(default="big", description="big: the high word of a value first")
    refusal: Refusal = Field(
        default="server_failure", description="response to a value or command that is refused: exception 04, or 03"
    )
    increments_per_unit: int = Field(default=1000, ge=1, le=1_000_000, description="increments per unit of length")
    units: dict[Symbol, int] = Field(
        default_factory=dict, description="increments per unit of single axes, by their symbolic names"
    )
    limits: dict[Symbol, AxisLimits] = Field(
        default_factory=dict, description="limit switches and software limits, by the symbolic names of the axes"
    )
    watchdog_ms: int = Field(
        default=0, ge=0, description="time without a request after which axes that clients have started stop; 0: never"
    )
    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="MAx-4", product_name="PacController"),
        description="response to function 43/14",
    )
