"""A Modbus exchange as a log shows it: a request with its answer."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class ModbusExchange:
    """A request, and the response that answers it."""

    begin_ns: int
    end_ns: int | None
    bus: str
    entries: tuple[int, ...]
    unit: int
    client: str
    """The sender of the request, as the log names it."""
    request: bytes
    """The PDU: function code and data."""
    response: bytes | None
    """The PDU; the first byte of an exception has the bit 80h.  None if no answer came."""
    server: str = ""
    """The sender of the response, as the log names it."""
    is_broadcast: bool = False
    """True for a request to unit 0 of a serial line, which no server answers."""
    wrong: str = ""
    """The reason in words why there is no response."""

    @property
    def exception(self) -> int | None:
        """The exception code of the response, if it has one; 0 if the response ends before it."""
        if self.response is None or not self.response[0] & 0x80:
            return None
        return self.response[1] if len(self.response) > 1 else 0
