"""The exception codes of a server (Modbus application protocol V1.1b3, chapter 7)."""

from typing import Final

ILLEGAL_FUNCTION: Final = 0x01
ILLEGAL_DATA_ADDRESS: Final = 0x02
ILLEGAL_DATA_VALUE: Final = 0x03
SERVER_DEVICE_FAILURE: Final = 0x04


class ModbusError(Exception):
    """Raised to answer the request with this exception code."""

    def __init__(self, code: int) -> None:
        super().__init__(f"Modbus exception {code:#04x}")
        self.code = code
