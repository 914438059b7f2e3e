"""The words at the head of each record: the master's control word and the drive's status word.

Source: IEC 61491 by its public facts, S-0-0134 and S-0-0135.  Bits 0 to 5 of the control word and 0 to 2 of the
status word belong to the service channel (`service`).
"""

from typing import Final

# control word
DRIVE_ON: Final = 0x8000
ENABLE: Final = 0x4000
RUN: Final = 0x2000
"""Halt/restart: 1 lets the drive follow its command values."""
MODE_MASK: Final = 0x0300
APPLICATION_MASK: Final = DRIVE_ON | ENABLE | RUN | MODE_MASK
"""Bits that concern the drive, not its ring interface."""
# status word
NOT_READY: Final = 0x0000
READY_FOR_POWER: Final = 0x4000
POWERED: Final = 0x8000
"""Ready with power applied, without torque."""
IN_OPERATION: Final = 0xC000
"""In operation, with torque."""
CLASS_1_ERROR: Final = 0x2000
CLASS_2_CHANGED: Final = 0x1000
CLASS_3_CHANGED: Final = 0x0800
COMMAND_CHANGED: Final = 0x0020
"""A procedure command has ended."""
# interface status, S-0-0014
MST_FAILED: Final = 0x0008
MDT_FAILED: Final = 0x0010
INVALID_PHASE: Final = 0x0020
WRONG_ADVANCE: Final = 0x0040
WRONG_RETURN: Final = 0x0080
NOT_ACKNOWLEDGED: Final = 0x0100
