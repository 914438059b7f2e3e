"""The include files of the PAM: the masks of errors and states (chapter 12, sections 8.2 to 8.4 of the digest).

The manual prints no values for the codes of PORTERR.SYS; these are ours.  Misprints such as UNKNOW_PERIPH are the names
that applications use.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.pamring.axis_words import Error, Status

_ST1: Final = {
    **{str(bit.name): bit.value for bit in (*Error, *Status)},
    "HARD_ERROR": 0x00F8_1000,
    "SUPPLY_ERROR": 0x0018_0000,
}
_SMART_IO: Final = {
    "HEAP_OVERFLOW": 0x01,
    "FIFOS_ERRORS": 0x02,
    "CRC_ERROR": 0x04,
    "FRAME_TYPE": 0x08,
    **{f"OUT_OVERTEMP_{module}": 0x10 << (module - 1) for module in range(1, 9)},
    "OUT_OVERTEMP": 0xFF0,
    "AIR_OVERTEMP": 0x1000,
    "DC_MOTORS_POSITION_LOST": 0x2000,
    "DC_MOTORS_UNEXPECTED_MOVE": 0x4000,
    "DC_MOTORS_DO_NOT_STOP": 0x8000,
    "UNKNOWN_CMD": 0x1_0000,
    "UNALLOWED_CMD": 0x2_0000,
    "UNDECLARED_PERIPH": 0x4_0000,
    "UNKNOW_PERIPH": 0x8_0000,
    "DCM_TIMEOUT": 0x01,
    "DCM_LOWER_LIMIT": 0x02,
    "DCM_UPPER_LIMIT": 0x04,
    "DCM_INQ_POS_TIMEOUT": 0x08,
    "DCMOTOR_ABORT_ERROR": 0x07,
}
_PORT: Final = {
    "DUALPORT_MASTER_OK": 1,
    "DUALPORT_MASTER_STOPPED": 2,
    "RS422PORT_CONNECTED": 1,
    "RS422PORT_DICONNECTED": 2,
}
SYSTEM_FILES: Final[Mapping[str, Mapping[str, int]]] = {
    "ST1ERROR.SYS": _ST1,
    "SMARTERR.SYS": _SMART_IO,
    "PORTERR.SYS": _PORT,
}


_MISPRINTS: Final = {"STIERROR.SYS": "ST1ERROR.SYS"}
"""Names as the manual prints them once (line 9058)."""


def system_file(path: str) -> Mapping[str, int] | None:
    """Return the masks of a system file, in whatever folder of the old system it was; None for any other file."""
    name = path.replace("\\", "/").rpartition("/")[2].upper()
    return SYSTEM_FILES.get(_MISPRINTS.get(name, name))


def system_file_with(name: str) -> str:
    """Return the system file that defines a mask, or nothing."""
    return next((file for file, masks in SYSTEM_FILES.items() if name in masks), "")
