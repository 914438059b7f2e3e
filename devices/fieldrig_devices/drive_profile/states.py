"""States, commands and transitions of the power drive state machine.

Source: CiA 402-2 / IEC 61800-7-201, chapter 'power drive system state machine': the figure and the tables of states,
commands and transitions 0 to 16.
"""

from enum import Enum, auto
from typing import Final


class State(Enum):
    """States with their bits 0 to 3, 5 and 6 of the status word."""

    NOT_READY_TO_SWITCH_ON = 0x00
    SWITCH_ON_DISABLED = 0x40
    READY_TO_SWITCH_ON = 0x21
    SWITCHED_ON = 0x23
    OPERATION_ENABLED = 0x27
    QUICK_STOP_ACTIVE = 0x07
    FAULT_REACTION_ACTIVE = 0x0F
    FAULT = 0x08


class Command(Enum):
    """Commands of the control word.  'Disable operation' has the same bits as 'switch on'."""

    SHUTDOWN = auto()
    SWITCH_ON = auto()
    ENABLE_OPERATION = auto()
    DISABLE_VOLTAGE = auto()
    QUICK_STOP = auto()


FAULT_RESET: Final = 0x0080
"""Bit of the control word that acts on its rising edge."""

# Table 'command coding': a mask, and the bits under it.
COMMANDS: Final = (
    (0x0082, 0x0000, Command.DISABLE_VOLTAGE),
    (0x0086, 0x0002, Command.QUICK_STOP),
    (0x0087, 0x0006, Command.SHUTDOWN),
    (0x008F, 0x0007, Command.SWITCH_ON),
    (0x008F, 0x000F, Command.ENABLE_OPERATION),
)

# Table 'transitions', those with a command.  'Enable operation' in 'ready to switch on' passes 'switched on'.
TRANSITIONS: Final = {
    (State.SWITCH_ON_DISABLED, Command.SHUTDOWN): 2,
    (State.READY_TO_SWITCH_ON, Command.SWITCH_ON): 3,
    (State.READY_TO_SWITCH_ON, Command.ENABLE_OPERATION): 3,
    (State.SWITCHED_ON, Command.ENABLE_OPERATION): 4,
    (State.OPERATION_ENABLED, Command.SWITCH_ON): 5,
    (State.SWITCHED_ON, Command.SHUTDOWN): 6,
    (State.READY_TO_SWITCH_ON, Command.QUICK_STOP): 7,
    (State.READY_TO_SWITCH_ON, Command.DISABLE_VOLTAGE): 7,
    (State.OPERATION_ENABLED, Command.SHUTDOWN): 8,
    (State.OPERATION_ENABLED, Command.DISABLE_VOLTAGE): 9,
    (State.SWITCHED_ON, Command.DISABLE_VOLTAGE): 10,
    (State.SWITCHED_ON, Command.QUICK_STOP): 10,
    (State.OPERATION_ENABLED, Command.QUICK_STOP): 11,
    (State.QUICK_STOP_ACTIVE, Command.DISABLE_VOLTAGE): 12,
    (State.QUICK_STOP_ACTIVE, Command.ENABLE_OPERATION): 16,
}

# The same table: where each transition ends.
ENDS: Final = {
    0: State.NOT_READY_TO_SWITCH_ON,
    1: State.SWITCH_ON_DISABLED,
    2: State.READY_TO_SWITCH_ON,
    3: State.SWITCHED_ON,
    4: State.OPERATION_ENABLED,
    5: State.SWITCHED_ON,
    6: State.READY_TO_SWITCH_ON,
    7: State.SWITCH_ON_DISABLED,
    8: State.READY_TO_SWITCH_ON,
    9: State.SWITCH_ON_DISABLED,
    10: State.SWITCH_ON_DISABLED,
    11: State.QUICK_STOP_ACTIVE,
    12: State.SWITCH_ON_DISABLED,
    13: State.FAULT_REACTION_ACTIVE,
    14: State.FAULT,
    15: State.SWITCH_ON_DISABLED,
    16: State.OPERATION_ENABLED,
}


def command_of(control_word: int) -> Command | None:
    return next((command for mask, bits, command in COMMANDS if control_word & mask == bits), None)
