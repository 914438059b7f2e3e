"""What a rig file says about the MAx-4 as Modbus server."""

from typing import Literal

from pydantic import Field

from fieldrig.settings import Settings
from fieldrig_bus.modbus.identification import Identification
from fieldrig_devices.max4.configuration import Symbol
from fieldrig_devices.register_table import WordOrder


class ModbusFaceSettings(Settings):
    unit_id: int = Field(default=1, ge=1, le=247, description="unit id (slave address)")
    turnaround_ms: float = Field(default=2.0, ge=0, le=60_000, description="from a request to its response; 0: at once")
    word_order: WordOrder = Field(default="big", description="big: the high word of a value first")
    refusal: Literal["server_failure", "illegal_value"] = Field(
        default="server_failure", description="a value or command that is refused: exception 04, or 03"
    )
    increments_per_unit: int = Field(default=1000, ge=1, le=1_000_000, description="what a unit of length is")
    units: dict[Symbol, int] = Field(default_factory=dict, description="the same for single axes")
    watchdog_ms: int = Field(
        default=0, ge=0, description="axes stop that clients have set in motion when none asks for so long; 0: never"
    )
    identification: Identification = Field(
        default_factory=lambda: Identification(product_code="MAx-4", product_name="PacController"),
        description="function 43/14",
    )
