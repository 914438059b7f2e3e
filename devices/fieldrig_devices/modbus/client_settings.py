"""Settings of a controller as a Modbus client."""

from typing import Literal, Self

from pydantic import Field, model_validator

from fieldrig.settings import Settings
from fieldrig_bus.modbus.server import MOST_BITS_READ, MOST_BITS_WRITTEN, MOST_REGISTERS_READ, MOST_REGISTERS_WRITTEN
from fieldrig_devices.registers.packed import CellName, Element


class _Message(Settings):
    """Consecutive registers or bits."""

    address: int = Field(ge=0, le=0xFFFF, description="address of the first register or bit, as on the wire")
    values: list[Element] = Field(min_length=1, description="the values in these registers or bits, in order")

    def check_room(self, is_bits: bool, most: int) -> None:
        if is_bits and any(value.type != "bool" for value in self.values):
            raise ValueError("values: expected type bool for each bit")
        count = len(self.values) if is_bits else sum(value.words for value in self.values)
        if count > most:
            raise ValueError(f"values: expected at most {most} in a message, got {count}")
        if self.address + count > 0x1_0000:
            raise ValueError("address: expected that all values end at 65535 or below")


class ReadSettings(_Message):
    what: Literal["coils", "discrete_inputs", "holding_registers", "input_registers"] = Field(
        default="holding_registers", description="what the values are"
    )
    every_ms: int = Field(default=100, ge=1, description="period of the requests")

    @model_validator(mode="after")
    def _fits_a_message(self) -> Self:
        is_bits = self.what in ("coils", "discrete_inputs")
        self.check_room(is_bits, MOST_BITS_READ if is_bits else MOST_REGISTERS_READ)
        return self


class WriteSettings(_Message):
    what: Literal["coils", "holding_registers"] = Field(default="holding_registers", description="what the values are")
    every_ms: int = Field(default=0, ge=0, description="period of requests without a change; 0: none")

    @model_validator(mode="after")
    def _fits_a_message(self) -> Self:
        is_bits = self.what == "coils"
        self.check_room(is_bits, MOST_BITS_WRITTEN if is_bits else MOST_REGISTERS_WRITTEN)
        return self


class ClientUnitSettings(Settings):
    """One unit that the client reads and writes."""

    unit: int = Field(ge=1, le=247, description="unit id")
    reads: list[ReadSettings] = Field(default_factory=list, description="messages that are read cyclically")
    writes: list[WriteSettings] = Field(
        default_factory=list, description="messages that are written when a value has changed"
    )
    lost_inputs: Literal["zero", "hold"] = Field(
        default="zero", description="values of a lost unit: 0, or the last ones"
    )

    @model_validator(mode="after")
    def _names_differ(self) -> Self:
        messages: list[_Message] = [*self.reads, *self.writes]
        names = [value.name.casefold() for message in messages for value in message.values]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            raise ValueError(f"values: expected each name once, got {', '.join(twice)} several times")
        return self


class ModbusClientSettings(Settings):
    link: int = Field(default=1, ge=1, description="position of the bus in links.modbus, from 1")
    timeout_ms: int = Field(default=500, ge=1, description="longest time to wait for a response")
    retries: int = Field(default=2, ge=0, description="further attempts before a unit is reported as lost")
    pause_ms: int = Field(default=1000, ge=1, description="time between two attempts to reach a lost unit")
    units: dict[CellName, ClientUnitSettings] = Field(default_factory=dict, description="units by name")
