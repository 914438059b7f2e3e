"""What a rig file says about the MAx-4 as Modbus client."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_bus.modbus.server import MOST_BITS_READ, MOST_BITS_WRITTEN, MOST_REGISTERS_READ, MOST_REGISTERS_WRITTEN
from fieldrig_devices.max4.configuration.files import Symbol
from fieldrig_devices.max4.field_data import Element


class _Message(Settings):
    """Registers or bits in a row."""

    address: int = Field(ge=0, le=0xFFFF, description="of the first register or bit, as on the wire")
    values: list[Element] = Field(min_length=1, description="what is there, one behind the other")

    def check_room(self, is_bits: bool, most: int) -> None:
        if is_bits and any(value.type != "bool" for value in self.values):
            raise ValueError("bits: type bool would be right for each value")
        count = len(self.values) if is_bits else sum(value.words for value in self.values)
        if count > most:
            raise ValueError(f"{count} in one message, and {most} are the most")
        if self.address + count > 0x1_0000:
            raise ValueError("it goes beyond address 65535")


class ReadSettings(_Message):
    what: Literal["coils", "discrete_inputs", "holding_registers", "input_registers"] = Field(
        default="holding_registers", description="where"
    )
    every_ms: int = Field(default=100, ge=1, description="how often")

    @model_validator(mode="after")
    def _fits_a_message(self) -> Self:
        is_bits = self.what in ("coils", "discrete_inputs")
        self.check_room(is_bits, MOST_BITS_READ if is_bits else MOST_REGISTERS_READ)
        return self


class WriteSettings(_Message):
    what: Literal["coils", "holding_registers"] = Field(default="holding_registers", description="where")
    every_ms: int = Field(default=0, ge=0, description="also without a change; 0: only then")

    @model_validator(mode="after")
    def _fits_a_message(self) -> Self:
        is_bits = self.what == "coils"
        self.check_room(is_bits, MOST_BITS_WRITTEN if is_bits else MOST_REGISTERS_WRITTEN)
        return self


class ClientUnitSettings(Settings):
    """One unit that is asked."""

    unit: int = Field(ge=1, le=247, description="unit id")
    reads: list[ReadSettings] = Field(default_factory=list, description="what is read cyclically")
    writes: list[WriteSettings] = Field(default_factory=list, description="what is written when it has changed")
    lost_inputs: Literal["zero", "hold"] = Field(default="zero", description="what values of a lost unit show")

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        messages: list[_Message] = [*self.reads, *self.writes]
        names = [one.name.casefold() for message in messages for one in message.values]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"values {', '.join(twice)}: each name once would be right")
        return self


class ModbusClientSettings(Settings):
    link: int = Field(default=1, ge=1, description="which of the buses under links.modbus")
    timeout_ms: int = Field(default=500, ge=1, description="for an answer")
    retries: int = Field(default=2, ge=0, description="before a unit counts as lost")
    pause_ms: int = Field(default=1000, ge=1, description="between two tries at a lost unit")
    units: dict[Symbol, ClientUnitSettings] = Field(default_factory=dict, description="by symbolic name")
