"""The error words of node and motor against the masks that applications include."""

import pytest

from fieldrig_devices.pam.language.system_files import SYSTEM_FILES
from fieldrig_devices.smart_io.troubles import MOTOR_BITS, NODE_BITS, FaultCode, heat_sink_bit

NODE_MASKS = {
    FaultCode.HEAP: "HEAP_OVERFLOW", FaultCode.FIFO: "FIFOS_ERRORS", FaultCode.CRC: "CRC_ERROR",
    FaultCode.FRAME_TYPE: "FRAME_TYPE",
    FaultCode.AMBIENT: "AIR_OVERTEMP", FaultCode.POSITION_LOST: "DC_MOTORS_POSITION_LOST",
    FaultCode.UNEXPECTED_MOVE: "DC_MOTORS_UNEXPECTED_MOVE", FaultCode.DOES_NOT_STOP: "DC_MOTORS_DO_NOT_STOP",
    FaultCode.UNKNOWN_COMMAND: "UNKNOWN_CMD", FaultCode.COMMAND_NOT_ALLOWED: "UNALLOWED_CMD",
    FaultCode.UNDECLARED_ITEM: "UNDECLARED_PERIPH", FaultCode.UNKNOWN_TYPE: "UNKNOW_PERIPH",
}  # fmt: skip
MOTOR_MASKS = {
    FaultCode.TIMEOUT: "DCM_TIMEOUT", FaultCode.LOWER_LIMIT: "DCM_LOWER_LIMIT",
    FaultCode.UPPER_LIMIT: "DCM_UPPER_LIMIT",
    FaultCode.POSITION_LOST: "DC_MOTORS_POSITION_LOST", FaultCode.UNEXPECTED_MOVE: "DC_MOTORS_UNEXPECTED_MOVE",
    FaultCode.DOES_NOT_STOP: "DC_MOTORS_DO_NOT_STOP",
}  # fmt: skip
"""Names of the tables 12-2 and 12-3, as printed."""


@pytest.mark.manual("PAMS-051")
@pytest.mark.manual("PAMS-053")
def test_the_bits_of_the_error_words_are_the_masks_of_smarterr_sys() -> None:
    masks = SYSTEM_FILES["SMARTERR.SYS"]
    assert {fault: masks[name] for fault, name in NODE_MASKS.items()} == NODE_BITS
    assert {fault: masks[name] for fault, name in MOTOR_MASKS.items()} == MOTOR_BITS
    assert [heat_sink_bit(module) for module in range(1, 9)] == [masks[f"OUT_OVERTEMP_{n}"] for n in range(1, 9)]
    assert heat_sink_bit(9) == 0, "modules 9 to 16 have no bit"
