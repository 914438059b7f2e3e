"""A SinCos encoder on its parameter channel, as bytes and times, without I/O.

A request ends with its last byte, whose number follows from the command, or with silence.  If it has our address or the
broadcast address, it is answered even if it is invalid.  `requests` carries it out.

Our choices: the time of an answer (within the limits of drives), no reception for 100 ms after power-on and reset, and
an incomplete request is dropped after 20 ms (a real encoder takes 55 bit times, finer than real time on a host).
Left out: parity errors, which no serial line here has; the extended type label (field FFh), which these types lack;
proprietary programs of the manufacturer.
"""

from collections.abc import Callable, Mapping
from typing import Final

from fieldrig.clock import MS, S
from fieldrig_bus.serial.message import Format
from fieldrig_devices.hiperface import mode
from fieldrig_devices.hiperface.memory import Eeprom, Field, RefusedError, status_for
from fieldrig_devices.hiperface.plate import NamePlate
from fieldrig_devices.hiperface.requests import WRITING_COMMANDS, Requests
from fieldrig_devices.hiperface.shaft import EncoderType, Turning
from fieldrig_devices.hiperface.telegram import BROADCAST, ERROR_BIT, Command, framed, request_length

DEAF_NS: Final = 100 * MS
PATIENCE_NS: Final = 20 * MS
QUERY_NS: Final = 1 * MS
READ_NS: Final = 4 * MS
CHANGE_NS: Final = 60 * MS

DELAYS_NS: Final[Mapping[int, int]] = {
    Command.READ_DATA: READ_NS,
    **dict.fromkeys(WRITING_COMMANDS, CHANGE_NS),
}
"""Time from the end of a request to the start of its answer; `QUERY_NS` for other commands."""


def eeprom_with(plate: NamePlate) -> Eeprom:
    """Return the memory as delivered: the plate in data field 0, protected by code 0."""
    data = plate.encode()
    return Eeprom(fields=[Field(status_for(len(data)), bytearray(data))])


class HiperfaceEncoder:
    def __init__(
        self,
        encoder_type: EncoderType,
        eeprom: Eeprom,
        shaft: Callable[[int], Turning],
        *,
        serial_number: str = "FR0000001",
        version: str = "fieldrig 1",
        on_change: Callable[[], None] = lambda: None,
    ) -> None:
        """`shaft` returns the position of the shaft at an instant.

        `on_change` is called after a write to the memory and before its answer; a StoreError refuses the request.
        """
        self.eeprom = eeprom
        self.answered = 0
        self.requests = Requests(encoder_type, eeprom, shaft, (serial_number, version), on_change)
        self.requests.on_reset = self.start
        self._request = bytearray()
        self._is_waiting_for_silence = False
        self._heard_ns = 0
        self._deaf_until_ns = 0
        self._answer: tuple[int, bytes] | None = None
        self._configure()

    @property
    def form(self) -> Format:
        """Format of the line since the last start."""
        return self._form

    def start(self, now_ns: int) -> None:
        """Start after power-on or a reset."""
        self._configure()
        self._deaf_until_ns = now_ns + DEAF_NS
        self._request.clear()
        self._answer = None

    # ---- bytes and time

    def receive(self, now_ns: int, data: bytes) -> None:
        """Take bytes, the last of which has just arrived."""
        silence_ns = now_ns - self._heard_ns - len(data) * self._character_ns
        self._heard_ns = now_ns
        if self._answer is not None or now_ns < self._deaf_until_ns:
            self._is_waiting_for_silence = True
            return
        if self._is_waiting_for_silence and silence_ns < self._silence_ns:
            return
        self._is_waiting_for_silence = False
        for index, byte in enumerate(data):
            self._request.append(byte)
            if self._request[0] not in (self.eeprom.address, BROADCAST):
                self._drop()
                return
            if request_length(self._request) == len(self._request):
                self._is_waiting_for_silence = index + 1 < len(data)
                self._take(now_ns)
                return

    def next_ns(self) -> int | None:
        """Return the instant at which `due` has to be called."""
        if self._answer is not None:
            return self._answer[0]
        return self._heard_ns + PATIENCE_NS if self._request else None

    def due(self, now_ns: int) -> bytes:
        """Return the bytes to send now."""
        if self._answer is not None and self._answer[0] <= now_ns:
            _, sent = self._answer
            self._answer = None
            self.answered += 1
            return sent
        if self._request and now_ns >= self._heard_ns + PATIENCE_NS:
            self._take(now_ns)
        return b""

    def _configure(self) -> None:
        self._form = mode.format_of(self.eeprom.mode)
        self._silence_ns = mode.silence_ns(self.eeprom.mode)
        self._character_ns = self._form.bits_per_character * S // self._form.baud

    def _drop(self) -> None:
        self._request.clear()
        self._is_waiting_for_silence = True

    def _take(self, now_ns: int) -> None:
        """Take a request that has ended."""
        request = bytes(self._request)
        self._request.clear()
        if len(request) < 2 or self.requests.trouble.is_silent():
            return
        command = request[1]
        try:
            data = self.requests.carry_out(now_ns, request)
        except RefusedError as refused:
            command, data = Command.READ_STATUS, bytes((refused.status,))
        if data is None:
            return
        answer = framed(self.eeprom.address, command | (ERROR_BIT if self.requests.messages else 0), data)
        if self.requests.trouble.is_garbling():
            answer = answer[:-1] + bytes((answer[-1] ^ 0xFF,))
        self._answer = (now_ns + DELAYS_NS.get(request[1], QUERY_NS), answer)
