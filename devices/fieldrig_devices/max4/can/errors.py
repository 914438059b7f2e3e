"""Error codes of CiA 402 for the diagnoses of a MAx-4 and its drives.

Source: CiA 402-2 and IEC 61800-7-201, annex 'error codes' (603Fh and EMCY); the assignment to diagnoses is our choice.
The keys are whole codes, because 117 has two meanings (digest X4); a code with a changed class is found by its three
digits.  A code that is not in the table becomes FF00h, which is manufacturer-specific.
"""

from typing import Final

from fieldrig_devices.max4.messages.catalogue import Code
from fieldrig_devices.mc4.diagnosis import Code as DriveCode

UNKNOWN: Final = 0xFF00

ERRORS: Final[dict[int, int]] = {
    DriveCode.ENCODER_SIGNAL: 0x7305,  # incremental sensor 1
    DriveCode.ENCODER_MEMORY: 0x7305,
    DriveCode.OVERVOLTAGE: 0x3210,  # DC link over-voltage
    DriveCode.UNDERVOLTAGE: 0x3220,  # DC link under-voltage
    DriveCode.MAINS_PHASE: 0x3130,  # phase failure
    DriveCode.DC_BUS_CONTROLLER: 0x7500,  # communication
    DriveCode.RING: 0x7500,
    DriveCode.STOP_TIME_LIMIT: 0x8400,  # velocity speed controller
    DriveCode.OVERLOAD_STOP_TIME: 0x8400,
    DriveCode.MOTOR_TEMPERATURE: 0x4310,  # excess temperature drive
    DriveCode.AMPLIFIER_TEMPERATURE: 0x4210,  # excess temperature device
    DriveCode.OVERLOAD: 0x2350,  # load level fault (I2t, thermal state)
    DriveCode.FOLLOWING_ERROR: 0x8611,  # following error
    DriveCode.SUPPLY_24V: 0x5112,  # supply low voltage, + 24 V
    Code.SERIOUS_CYCLE_ERROR: 0x6200,  # user software
    Code.CYCLE_ERROR: 0x6200,
    Code.DIVISION_ERROR: 0x6200,
    Code.WRITE_OVERFLOW: 0x6100,  # internal software
    Code.RING_OPEN: 0x7500,
    Code.AT_FAILED: 0x7500,
    Code.DRIVE_MISSING: 0x7500,
    Code.DRIVE_REFUSED: 0x7500,
    Code.NO_ROOM: 0x7500,
    Code.VERSION: 0x6100,
    Code.CONFIGURATION: 0x6320,  # parameter error
    Code.RAM_LOST: 0x5530,  # EEPROM, here buffered memory
}


def error_of(diag_code: int) -> int:
    """The error code of a diagnosis; 0 for 0."""
    if not diag_code:
        return 0
    if diag_code in ERRORS:
        return ERRORS[diag_code]
    return next((error for code, error in ERRORS.items() if code % 1000 == diag_code % 1000), UNKNOWN)
