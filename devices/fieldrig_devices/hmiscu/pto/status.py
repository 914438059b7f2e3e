"""The status of an axis: its motion state (digest 6), and the bits of PTODiag (SCU-059, digest 8.2)."""

from enum import IntEnum, IntFlag


class MotionState(IntEnum):
    """The numbers are those of the suggested register map."""

    STANDSTILL = 0
    DISCRETE_MOTION = 1
    CONTINUOUS_MOTION = 2
    STOPPING = 3
    ERROR_STOP = 4


class Diagnosis(IntFlag):
    """The bits of PTODiag."""

    NONE = 0
    INTERNAL_ERROR = 1 << 4
    CONFIGURATION_ERROR = 1 << 7
    DRIVE_NOT_READY = 1 << 17
    INVALID_FREQUENCY = 1 << 22
    INVALID_ACCELERATION = 1 << 23
    INVALID_DECELERATION = 1 << 24
    COMMAND_REJECTED = 1 << 25
    INVALID_DIRECTION = 1 << 26
