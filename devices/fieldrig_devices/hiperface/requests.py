"""The commands of the parameter channel, as an encoder carries them out on its memory and its shaft.

Commands and their sources: `telegram`; rules of the memory: `memory`; position: `shaft`.  Errors of the encoder
itself are stored, up to four messages; each 50h returns one.
"""

from collections import deque
from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass
from typing import Final

from fieldrig.storage.store import StoreError
from fieldrig_devices.hiperface import mode
from fieldrig_devices.hiperface.memory import COUNTS, SIZE_IN_BLOCKS, Eeprom, RefusedError
from fieldrig_devices.hiperface.shaft import AMPLITUDE, FASTEST, EncoderType, Turning, signals, steps_of
from fieldrig_devices.hiperface.telegram import (
    ADDRESSES,
    COSINE,
    SERIAL_LENGTH,
    SINE,
    TEMPERATURE,
    VERSION_LENGTH,
    Command,
    Status,
    checksum,
    request_length,
)

MESSAGES: Final = 4
"""Largest number of stored messages (Moog MSD manual: four bytes of error memory)."""
HOT_DEGC: Final = 115
OPTIONS: Final = 0x00
WRITING_COMMANDS: Final = frozenset(
    {
        Command.SET_POSITION, Command.INCREASE_COUNTER, Command.CLEAR_COUNTER, Command.STORE_DATA, Command.CREATE_FIELD,
        Command.CHANGE_CODE, Command.ALLOCATE_ADDRESS, Command.CONFIGURE_SERIAL,
    }
)  # fmt: skip
MEMORY_COMMANDS: Final = frozenset({Command.READ_DATA, Command.STORE_DATA, Command.CREATE_FIELD})


@dataclass(slots=True)
class Trouble:
    """The active faults; each function is called for every request."""

    is_silent: Callable[[], bool] = lambda: False
    is_memory_dead: Callable[[], bool] = lambda: False
    is_garbling: Callable[[], bool] = lambda: False
    """True if the answer gets a wrong checksum."""
    plate: Callable[[bytes], bytes] = lambda field: field
    """Returns data field 0 as read, given its true content."""


class Requests:
    def __init__(
        self,
        encoder_type: EncoderType,
        eeprom: Eeprom,
        shaft: Callable[[int], Turning],
        identity: tuple[str, str],
        on_change: Callable[[], None],
    ) -> None:
        """`identity` is serial number and version."""
        serial_number, version = (text.encode("ascii", "replace") for text in identity)
        self.kind, self.eeprom, self.trouble = encoder_type, eeprom, Trouble()
        self.temperature_degc = 25
        self.messages: deque[Status] = deque(maxlen=MESSAGES)
        self.on_reset: Callable[[int], None] = lambda _now_ns: None
        self._shaft, self._on_change = shaft, on_change
        self._identity = serial_number.ljust(SERIAL_LENGTH)[:SERIAL_LENGTH]
        self._identity += version.ljust(VERSION_LENGTH)[:VERSION_LENGTH]

    def report(self, status: Status) -> None:
        """Store a message for 50h about an error of the encoder itself."""
        if status not in self.messages:
            self.messages.append(status)

    def set_temperature(self, degc: float) -> None:
        before, self.temperature_degc = self.temperature_degc, round(min(max(degc, -0x8000), 0x7FFF))
        if before <= HOT_DEGC < self.temperature_degc:
            self.report(Status.TEMPERATURE)

    def position(self, now_ns: int) -> int:
        """Return the position in steps, as in the answer to 42h."""
        return (steps_of(self._shaft(now_ns).turns) + self.eeprom.offset) % self.kind.range

    def carry_out(self, now_ns: int, request: bytes) -> bytes | None:
        """Return the data of the answer to a request, or None without an answer.  RefusedError has the status."""
        if len(request) < 3 or request[1] not in _COMMANDS:
            raise RefusedError(Status.LENGTH if request[1] in _COMMANDS else Status.COMMAND)
        if request_length(request) != len(request):
            raise RefusedError(Status.LENGTH)
        if checksum(request):
            raise RefusedError(Status.CHECKSUM)
        command, data = Command(request[1]), request[2:-1]
        if command in MEMORY_COMMANDS and self.trouble.is_memory_dead():
            raise RefusedError(Status.MEMORY_CHECKSUM)
        before = deepcopy(self.eeprom) if command in WRITING_COMMANDS else self.eeprom
        try:
            return _COMMANDS[command](self, now_ns, data)
        except StoreError as cause:  # our reading: 05h, because the memory does not answer the write
            self.eeprom.become(before)
            raise RefusedError(Status.I2C_BUS) from cause

    def _on_read_position(self, now_ns: int, _data: bytes) -> bytes:
        if abs(self._shaft(now_ns).speed) > FASTEST:
            raise RefusedError(Status.SPEED)
        return self.position(now_ns).to_bytes(4, "big")

    def _on_set_position(self, now_ns: int, data: bytes) -> bytes:
        self.eeprom.check_code(0, data[4])
        position = int.from_bytes(data[:4], "big")
        if position >= self.kind.range:
            raise RefusedError(Status.ARGUMENT)
        self.eeprom.offset = (position - steps_of(self._shaft(now_ns).turns)) % self.kind.range
        self._on_change()
        return b""

    def _on_read_analog(self, now_ns: int, data: bytes) -> bytes:
        seen = signals(self._shaft(now_ns).turns)
        values = {
            TEMPERATURE: self.temperature_degc,
            SINE: round(seen.sine * AMPLITUDE),
            COSINE: round(seen.cosine * AMPLITUDE),
        }
        if data[0] not in values:
            raise RefusedError(Status.ARGUMENT)
        return data + values[data[0]].to_bytes(2, "big", signed=True)

    def _on_read_counter(self, _now_ns: int, _data: bytes) -> bytes:
        return self.eeprom.counter.to_bytes(3, "big")

    def _on_increase_counter(self, _now_ns: int, _data: bytes) -> bytes:
        if self.eeprom.counter == COUNTS - 1:
            raise RefusedError(Status.COUNTER)
        self.eeprom.counter += 1
        self._on_change()
        return b""

    def _on_clear_counter(self, _now_ns: int, data: bytes) -> bytes:
        self.eeprom.check_code(0, data[0])
        self.eeprom.counter = 0
        self._on_change()
        return b""

    def _on_read_data(self, _now_ns: int, data: bytes) -> bytes:
        field, address, count, code = data
        read = self.eeprom.read(field, address, count, code)
        if field == 0:
            seen = self.trouble.plate(bytes(self.eeprom.fields[0].data))
            read = seen[address : address + count]
        return data[:3] + read

    def _on_store_data(self, _now_ns: int, data: bytes) -> bytes:
        field, address, _, code = data[:4]
        self.eeprom.store(field, address, data[4:], code)
        self._on_change()
        return data[:3]

    def _on_field_status(self, _now_ns: int, data: bytes) -> bytes:
        return data + bytes((self.eeprom.field(data[0]).status,))

    def _on_create_field(self, _now_ns: int, data: bytes) -> bytes:
        self.eeprom.create(*data)
        self._on_change()
        return data[:2]

    def _on_available_memory(self, _now_ns: int, _data: bytes) -> bytes:
        return self.eeprom.free.to_bytes(2, "big") + bytes((len(self.eeprom.fields),))

    def _on_change_code(self, _now_ns: int, data: bytes) -> bytes:
        self.eeprom.change_code(*data)
        self._on_change()
        return data[:1]

    def _on_read_status(self, _now_ns: int, _data: bytes) -> bytes:
        return bytes((self.messages.popleft() if self.messages else Status.NO_ERROR,))

    def _on_type_label(self, _now_ns: int, _data: bytes) -> bytes:
        return bytes((self.eeprom.mode, self.kind.code, SIZE_IN_BLOCKS, OPTIONS))

    def _on_reset(self, now_ns: int, _data: bytes) -> None:
        self.on_reset(now_ns)

    def _on_allocate_address(self, _now_ns: int, data: bytes) -> bytes:
        self.eeprom.check_code(0, data[1])
        if data[0] not in ADDRESSES:
            raise RefusedError(Status.ARGUMENT)
        self.eeprom.address = data[0]
        self._on_change()
        return data[:1]

    def _on_serial_number(self, _now_ns: int, _data: bytes) -> bytes:
        return self._identity

    def _on_configure_serial(self, _now_ns: int, data: bytes) -> bytes:
        """Set the mode, which takes effect at the next start."""
        self.eeprom.check_code(0, data[1])
        if not mode.is_right(data[0]):
            raise RefusedError(Status.ARGUMENT)
        self.eeprom.mode = data[0]
        self._on_change()
        return data[:1]


_COMMANDS: Final[dict[int, Callable[[Requests, int, bytes], bytes | None]]] = {
    Command.READ_POSITION: Requests._on_read_position,
    Command.SET_POSITION: Requests._on_set_position,
    Command.READ_ANALOG: Requests._on_read_analog,
    Command.READ_COUNTER: Requests._on_read_counter,
    Command.INCREASE_COUNTER: Requests._on_increase_counter,
    Command.CLEAR_COUNTER: Requests._on_clear_counter,
    Command.READ_DATA: Requests._on_read_data,
    Command.STORE_DATA: Requests._on_store_data,
    Command.FIELD_STATUS: Requests._on_field_status,
    Command.CREATE_FIELD: Requests._on_create_field,
    Command.AVAILABLE_MEMORY: Requests._on_available_memory,
    Command.CHANGE_CODE: Requests._on_change_code,
    Command.READ_STATUS: Requests._on_read_status,
    Command.TYPE_LABEL: Requests._on_type_label,
    Command.RESET: Requests._on_reset,
    Command.ALLOCATE_ADDRESS: Requests._on_allocate_address,
    Command.SERIAL_NUMBER: Requests._on_serial_number,
    Command.CONFIGURE_SERIAL: Requests._on_configure_serial,
}
