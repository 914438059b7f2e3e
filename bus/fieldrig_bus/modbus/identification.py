"""The identification of a server: device identification (function 43/14) and server id (17).

Source: Modbus application protocol V1.1b3, 6.13 and 6.21.
"""

from typing import Annotated, Final

from pydantic import Field, StringConstraints

from fieldrig.settings import Settings
from fieldrig_bus.modbus.errors import ILLEGAL_DATA_ADDRESS, ILLEGAL_DATA_VALUE, ILLEGAL_FUNCTION, ModbusError

READ_DEVICE_ID: Final = 0x0E
BASIC, REGULAR, EXTENDED, SPECIFIC = 1, 2, 3, 4
LAST_OBJECT: Final = {BASIC: 0x02, REGULAR: 0x7F, EXTENDED: 0xFF}
INDIVIDUAL_TOO: Final = 0x80  # added to the conformity level: objects can also be read individually

LONGEST_PDU: Final = 253
HEAD_SIZE: Final = 7
LONGEST_OBJECT: Final = LONGEST_PDU - HEAD_SIZE - 2

Text = Annotated[str, Field(max_length=LONGEST_OBJECT, pattern=r"^[\x20-\x7E]*$", description="in ASCII")]


class Identification(Settings):
    """Objects of ASCII text.  The first three are mandatory; each of the others exists if it has a value."""

    vendor_name: Text = "fieldrig"
    product_code: Text = "modbus.device"
    revision: Text = Field(default="1.0", description="MajorMinorRevision")
    vendor_url: Text | None = None
    product_name: Text | None = None
    model_name: Text | None = None
    user_application_name: Text | None = None
    extended: dict[Annotated[int, Field(ge=0x80, le=0xFF)], Text] = Field(
        default_factory=dict, description="private objects by id, 0x80 to 0xFF"
    )

    def objects(self) -> dict[int, bytes]:
        named = (
            self.vendor_name,
            self.product_code,
            self.revision,
            self.vendor_url,
            self.product_name,
            self.model_name,
            self.user_application_name,
        )
        present = {number: text.encode("ascii") for number, text in enumerate(named) if text is not None}
        return present | {number: self.extended[number].encode("ascii") for number in sorted(self.extended)}

    def answer(self, pdu: bytes) -> bytes:
        """The response to function 43.  ModbusError for a request that cannot be answered."""
        if len(pdu) >= 2 and pdu[1] != READ_DEVICE_ID:
            raise ModbusError(ILLEGAL_FUNCTION)
        if len(pdu) != 4:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        code, first = pdu[2], pdu[3]
        objects = self.objects()
        highest = _level(objects)
        if code == SPECIFIC:
            if first not in objects:
                raise ModbusError(ILLEGAL_DATA_ADDRESS)
            return _response(code, highest, objects, [first])
        if code not in LAST_OBJECT:
            raise ModbusError(ILLEGAL_DATA_VALUE)
        # A device that is asked for a higher level than it has answers with the level that it has.
        numbers = [number for number in objects if number <= LAST_OBJECT[code]]
        if first in numbers:  # an unknown object id means that reading starts from the beginning
            numbers = numbers[numbers.index(first) :]
        return _response(code, highest, objects, numbers)


def _level(objects: dict[int, bytes]) -> int:
    last = max(objects)
    return next(level for level, last_of_level in LAST_OBJECT.items() if last <= last_of_level)


def _response(code: int, level: int, objects: dict[int, bytes], numbers: list[int]) -> bytes:
    """The complete objects that fit into one response; `more follows` says with which object to go on."""
    body, count, more, following = b"", 0, 0, 0
    for number in numbers:
        entry = bytes((number, len(objects[number]))) + objects[number]
        if HEAD_SIZE + len(body) + len(entry) > LONGEST_PDU:
            more, following = 0xFF, number
            break
        body += entry
        count += 1
    return bytes((0x2B, READ_DEVICE_ID, code, level | INDIVIDUAL_TOO, more, following, count)) + body


class ServerId(Settings):
    """The report of function 17: the id, the run indicator, and additional text of the vendor."""

    server_id: str = Field(
        default="01", pattern=r"^([0-9A-Fa-f]{2}){1,200}$", description="the id as hexadecimal digits, two per byte"
    )
    is_running: bool = Field(default=True, description="the run indicator: on (0xFF) or off (0x00)")
    additional: Annotated[str, StringConstraints(max_length=50, pattern=r"^[\x20-\x7E]*$")] = Field(
        default="fieldrig", description="text after the run indicator, in ASCII"
    )

    def data(self) -> bytes:
        return bytes.fromhex(self.server_id) + (b"\xff" if self.is_running else b"\x00") + self.additional.encode()
