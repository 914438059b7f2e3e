"""The error words of node and motor against the masks that applications include."""

import pytest

from fieldrig_devices.pam.language.system_files import SYSTEM_FILES
from fieldrig_devices.smart_io.troubles import MOTOR_BITS, NODE_BITS, Fault, heat_sink_bit

NODE_MASKS = {
    Fault.HEAP: "HEAP_OVERFLOW", Fault.FIFO: "FIFOS_ERRORS", Fault.CRC: "CRC_ERROR", Fault.FRAME_TYPE: "FRAME_TYPE",
    Fault.AMBIENT: "AIR_OVERTEMP", Fault.POSITION_LOST: "DC_MOTORS_POSITION_LOST",
    Fault.UNEXPECTED_MOVE: "DC_MOTORS_UNEXPECTED_MOVE", Fault.DOES_NOT_STOP: "DC_MOTORS_DO_NOT_STOP",
    Fault.UNKNOWN_COMMAND: "UNKNOWN_CMD", Fault.COMMAND_NOT_ALLOWED: "UNALLOWED_CMD",
    Fault.UNDECLARED_ITEM: "UNDECLARED_PERIPH", Fault.UNKNOWN_TYPE: "UNKNOW_PERIPH",
}  # fmt: skip
MOTOR_MASKS = {
    Fault.TIMEOUT: "DCM_TIMEOUT", Fault.LOWER_LIMIT: "DCM_LOWER_LIMIT", Fault.UPPER_LIMIT: "DCM_UPPER_LIMIT",
    Fault.POSITION_LOST: "DC_MOTORS_POSITION_LOST", Fault.UNEXPECTED_MOVE: "DC_MOTORS_UNEXPECTED_MOVE",
    Fault.DOES_NOT_STOP: "DC_MOTORS_DO_NOT_STOP",
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
