"""Base of all kinds of Modbus buses, and the settings of a serial line."""

from collections.abc import Sequence
from typing import Any, ClassVar, Final, Literal

from fieldrig.bus import ModelBus
from fieldrig.settings import Settings
from fieldrig_bus.modbus import codec, message
from fieldrig_bus.modbus.effects import ModbusEffects
from fieldrig_bus.modbus.framing import LineTiming, Mode
from fieldrig_bus.modbus.message import ClientConnected, ModbusRequest, ModbusResponse, OnModbus
from fieldrig_bus.serial.message import Format

FAULTS: Final = "faults from the start"


class ModbusBus(ModelBus[OnModbus]):
    family: ClassVar[str] = "modbus"
    notes_faults: ClassVar[bool] = True
    messages: ClassVar[tuple[type, ...]] = (ModbusRequest, ModbusResponse, ClientConnected)
    settings: Any

    encode = staticmethod(codec.encode)
    decode = staticmethod(codec.decode)
    show = staticmethod(codec.show)
    check = staticmethod(message.check_sent)
    check_interest = staticmethod(message.check_interest)

    @property
    def line(self) -> tuple[LineTiming, Format] | None:
        """Timing and format of the serial line; None on TCP."""
        return None

    @property
    def timing_at_port(self) -> LineTiming | None:
        """Timing of a line that masters meet at its port, and members of the bus do not; None elsewhere."""
        return None

    def effects(self) -> ModbusEffects:
        timing, form = self.line or (None, None)
        return ModbusEffects(self.settings.faults, timing, form)

    def mbpoll(self) -> tuple[Sequence[str], str] | None:
        """Options and target of mbpoll as a master outside the rig; None where it cannot be one."""
        return None

    def pymodbus(self) -> str | None:
        """Steps in Python that connect `c`, a client of pymodbus, from outside; None where that is not possible."""
        return None


class CharacterSettings(Settings):
    """The format of a character, and so its duration."""

    parity: Literal["N", "E", "O"] = "E"
    stop_bits: Literal[1, 2] = 1
    data_bits: Literal[7, 8] = 8

    @property
    def bits_per_character(self) -> int:
        return 1 + self.data_bits + (self.parity != "N") + self.stop_bits

    def timing(self, mode: Mode, baud: int) -> LineTiming:
        return LineTiming(mode, baud, self.bits_per_character)

    def format(self, baud: int) -> Format:
        return Format(baud, self.data_bits, self.parity, self.stop_bits)
