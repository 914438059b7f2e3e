"""Addresses of the values that an encoder of the PAM reads from an ST1 (table 2-2: 2115-2160, PAML-142, PAML-149).

An address is a bank, which says how many bits are read, and a code.  The codes of most variables and parameters are in
a document of the ST1 that is lost: CACTIN, CVALIN, CACOUT and DAP_TEMP are the manual's, the others ours.
"""

from enum import IntEnum
from typing import Final, NamedTuple

FIRST_CODE: Final = 0x1B
"""Codes below it are reserved in every bank."""
LAST_CODE: Final = 0xFF


class Primary(IntEnum):
    """The addresses below the codes."""

    MAIN_RESOLVER = 0
    SECOND_RESOLVER = 1
    SET_POINT = 2
    INCREMENTAL_ENCODER = 3
    ANALOG = 4


class Variable(IntEnum):
    """Codes of variables, ours."""

    PHIRE = 0x1B
    PHIRE_2 = 0x1C
    PHIC = 0x1D
    SPEED = 0x1E
    SET_SPEED = 0x1F
    LAG = 0x20
    TORQUE_LIMIT = 0x21
    STATUS_AB = 0x22
    STATUS_CD = 0x23
    INPUTS = 0x24
    OUTPUTS = 0x25
    SUPPLY = 0x26


class Parameter(IntEnum):
    """Codes of parameters."""

    CKV = 0x1B
    CKA = 0x1C
    CKR = 0x1D
    CKH = 0x1E
    ASTOP = 0x1F
    PHIL1 = 0x20
    PHIL2 = 0x21
    EQUIP = 0x22
    CMASKS = 0x23
    CMASKU = 0x24
    CACTIN = 0xB2
    CVALIN = 0xB3
    CACOUT = 0xB4
    DAP_TEMP = 0xF9


class Register(NamedTuple):
    """An address of table 2-2."""

    bits: int
    is_periodic: bool
    """True if the application sees the value roll over."""
    code: int
    kind: type[Primary | Variable | Parameter]


_PRIMARY_BITS: Final = {Primary.ANALOG: 16}


def register_at(address: int) -> Register | None:
    """Return what is at an address; None for reserved addresses and holes."""
    if address in list(Primary):
        return Register(_PRIMARY_BITS.get(Primary(address), 32), True, address, Primary)
    bank, code = divmod(address, 256)
    if not 0 <= bank < 8 or not FIRST_CODE <= code <= LAST_CODE:
        return None
    return Register(32 if bank & 2 else 16, bool(bank & 1), code, Parameter if bank & 4 else Variable)


def parameter_address(code: Parameter) -> int:
    """Return the address of a parameter with 32 bits and without a period."""
    return 0x600 + code


def rolled(value: int, bits: int) -> int:
    """Return the lowest bits of a value, with a sign (PAML-146)."""
    half = 1 << (bits - 1)
    return (value + half) % (1 << bits) - half
