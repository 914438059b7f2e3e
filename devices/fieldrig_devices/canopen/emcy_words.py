"""An EMCY message in words.

Source: CiA 301 version 4.2, 7.2.7 and table 26 (error code classes), table 39 (bits of the error register).
"""

from typing import Final

from fieldrig_devices.canopen.dictionary import Dictionary
from fieldrig_devices.drive_profile.objects import is_drive_type
from fieldrig_devices.drive_profile.words import error_words

ERROR_CLASSES: Final = {
    0x00: "error reset or no error",
    0x10: "generic error",
    0x20: "current",
    0x21: "current, input side",
    0x22: "current inside the device",
    0x23: "current, output side",
    0x30: "voltage",
    0x31: "mains voltage",
    0x32: "voltage inside the device",
    0x33: "output voltage",
    0x40: "temperature",
    0x41: "ambient temperature",
    0x42: "device temperature",
    0x50: "device hardware",
    0x60: "device software",
    0x61: "internal software",
    0x62: "user software",
    0x63: "data set",
    0x70: "additional modules",
    0x80: "monitoring",
    0x81: "communication",
    0x82: "protocol error",
    0x90: "external error",
    0xF0: "additional functions",
    0xFF: "device specific",
}
ERROR_CODES: Final = {
    0x8110: "CAN overrun, objects lost",
    0x8120: "CAN in error passive mode",
    0x8130: "life guard or heartbeat error",
    0x8140: "recovered from bus off",
    0x8150: "CAN-ID collision",
    0x8210: "PDO not processed due to length error",
    0x8220: "PDO length exceeded",
    0x8230: "destination address mode multiplex PDO not processed",
    0x8240: "unexpected SYNC data length",
    0x8250: "RPDO timeout",
}
REGISTER_BITS: Final = ("generic", "current", "voltage", "temperature", "communication", "profile", "", "manufacturer")
LENGTH: Final = 8
DEVICE_TYPE: Final = 0x1000


def is_drive(dictionary: Dictionary) -> bool:
    """True if the device type of a node is that of a drive."""
    return is_drive_type(dictionary.number(DEVICE_TYPE, 0))


def meaning_of(code: int, *, is_drive: bool = False) -> str:
    """Return the meaning of an error code, or of its class; a drive's is that of CiA 402."""
    of_profile = error_words(code) if is_drive else ""
    return (
        of_profile or ERROR_CODES.get(code) or ERROR_CLASSES.get(code >> 8) or ERROR_CLASSES.get(code >> 8 & 0xF0, "")
    )


def emcy_words(data: bytes, *, is_drive: bool = False) -> str:
    """Return code, meaning, error register and further bytes of an EMCY message."""
    if len(data) != LENGTH:
        return f"{data.hex(' ').upper()} (expected eight bytes)"
    code, register = int.from_bytes(data[:2], "little"), data[2]
    meaning = meaning_of(code, is_drive=is_drive)
    bits = " ".join(name for bit, name in enumerate(REGISTER_BITS) if register >> bit & 1 and name)
    further = data[3:].hex(" ").upper() if any(data[3:]) else ""
    parts = [f"{code:04X}h {meaning}".strip(), f"register {register:02X}h{f' ({bits})' if bits else ''}", further]
    return ", ".join(part for part in parts if part)
