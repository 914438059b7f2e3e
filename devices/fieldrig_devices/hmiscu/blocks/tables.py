"""The pins of every block, one table per block, as in the figures and tables of the manual (digest 4).

Rows: SCU-009, SCU-028 to SCU-037, SCU-046 to SCU-052, SCU-057 to SCU-059, SCU-070 to SCU-074.
"""

from collections.abc import Mapping
from typing import Final

from fieldrig_devices.hmiscu.blocks.pins import BlockType, Pin, PinValue, Side


def _in(name: str, type_: str, about: str, default: PinValue = 0) -> Pin:
    return Pin(name, Side.INPUT, type_, default, about)


def _out(name: str, type_: str, about: str) -> Pin:
    return Pin(name, Side.OUTPUT, type_, 0, about)


_REF_IN: Final = _in("PTO_REF_IN", "PTO_REF", "channel, from PTO_REF or PTO_REF_OUT of another block")
_REF_OUT: Final = _out("PTO_REF_OUT", "PTO_REF", "the same channel, for the next block")
_EXECUTE: Final = _in("Execute", "BOOL", "a rising edge starts the block with the inputs of this instant")
_BUSY: Final = _out("Busy", "BOOL", "the command is in progress")
_ABORTED: Final = _out("CommandAborted", "BOOL", "another motion command ended this one")
_ERROR: Final = (
    _out("Error", "BOOL", "an error ended the command"),
    _out("ErrID", "PTOPWM_ERR_TYPE", "type of the error, while Error is TRUE"),
)
_RAMPS: Final = (
    _in("Acceleration", "DWORD", "Hz/ms: 1 to the maximum; ms: the minimum to 49999"),
    _in("Deceleration", "DWORD", "Hz/ms: 1 to the maximum; ms: the minimum to 49999"),
    _in("Direction", "PTO_DIRECTION", "0 positive, 1 negative, 2 that of the last move"),
)

PTO_SIMPLE: Final = BlockType(
    "PTOSimple",
    (
        _in("ResetError", "BOOL", "a rising edge resets the error once the axis is at rest"),
        _in("DIS_AuxInput", "BOOL", "TRUE ignores the input Drive Ready"),
        _out("PTO_REF", "PTO_REF", "the channel, for the other blocks"),
        _out("PTOError", "BOOL", "an error is pending"),
        _out("Moving", "BOOL", "a move is in progress"),
        _out("Stopping", "BOOL", "the axis decelerates to a stop"),
        _out("Frequency", "DWORD", "present frequency in Hz"),
        _out("Distance", "DWORD", "pulses since the start of the move, modulo 2^32"),
    ),
)

PTO_MOVE_RELATIVE: Final = BlockType(
    "PTOMoveRelative",
    (
        _REF_IN,
        _EXECUTE,
        _in("Velocity", "DWORD", "target frequency, 1 Hz to the maximum frequency"),
        _in("Distance", "DWORD", "1 to 4294967295 pulses"),
        *_RAMPS,
        _REF_OUT,
        _out("Done", "BOOL", "all pulses have been sent"),
        _BUSY,
        _out("Active", "BOOL", "the block controls the axis"),
        _ABORTED,
        *_ERROR,
    ),
)

PTO_MOVE_VELOCITY: Final = BlockType(
    "PTOMoveVelocity",
    (
        _REF_IN,
        _EXECUTE,
        _in("Velocity", "DWORD", "target frequency, 1 Hz to the maximum frequency"),
        *_RAMPS,
        _REF_OUT,
        _out("InVelocity", "BOOL", "the target frequency has been reached"),
        _BUSY,
        _ABORTED,
        *_ERROR,
    ),
)

PTO_STOP: Final = BlockType(
    "PTOStop",
    (
        _REF_IN,
        _EXECUTE,
        _in("Deceleration", "DWORD", "Hz/ms: 1 to the maximum; ms: the minimum to 49999"),
        _REF_OUT,
        _out("Done", "BOOL", "the axis is at rest"),
        _BUSY,
        *_ERROR,
    ),
)

_PARAM: Final = _in("Param", "PTO_PARAMETER_TYPE", "0 start frequency, 1 stop frequency")

PTO_GET_PARAM: Final = BlockType(
    "PTOGetParam",
    (
        _REF_IN,
        _EXECUTE,
        _PARAM,
        _REF_OUT,
        _out("Done", "BOOL", "ParamValue is valid"),
        _BUSY,
        *_ERROR,
        _out("ParamValue", "DWORD", "frequency in Hz"),
    ),
)

PTO_SET_PARAM: Final = BlockType(
    "PTOSetParam",
    (
        _REF_IN,
        _EXECUTE,
        _PARAM,
        _in("Param_Value", "DWORD", "0 to the maximum frequency in Hz"),
        _REF_OUT,
        _out("Done", "BOOL", "the value has been written"),
        _BUSY,
        *_ERROR,
    ),
)

PTO_GET_DIAG: Final = BlockType(
    "PTOGetDiag",
    (
        _REF_IN,
        _EXECUTE,
        _REF_OUT,
        _out("Done", "BOOL", "PTODiag is valid"),
        _BUSY,
        *_ERROR,
        _out("PTODiag", "DWORD", "bits of the causes of the error"),
    ),
)

PWM: Final = BlockType(
    "PWM",
    (
        _in("EN_Enable", "BOOL", "lets the input IN_EN enable the output"),
        _in("F_Enable", "BOOL", "enables the output"),
        _in("EN_Sync", "BOOL", "lets the input IN_SYNC restart the period"),
        _in("F_Sync", "BOOL", "a rising edge restarts the period"),
        _in("Frequency", "DWORD", "100 to 650000, in 0.1 Hz"),
        _in("Duty", "BYTE", "0 to 100 %"),
        _out("InFrequency", "BOOL", "the output has this frequency and duty cycle"),
        _out("Busy", "BOOL", "a change is under way"),
        *_ERROR,
    ),
)

BLOCK_TYPES: Final[Mapping[str, BlockType]] = {
    block.name: block
    for block in (
        PTO_SIMPLE,
        PTO_MOVE_RELATIVE,
        PTO_MOVE_VELOCITY,
        PTO_STOP,
        PTO_GET_PARAM,
        PTO_SET_PARAM,
        PTO_GET_DIAG,
        PWM,
    )
}
