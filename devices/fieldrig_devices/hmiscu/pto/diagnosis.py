"""Bits of PTODiag (SCU-059, digest 8.2)."""

from enum import IntFlag


class Diagnosis(IntFlag):
    NONE = 0
    INTERNAL_ERROR = 1 << 4
    CONFIGURATION_ERROR = 1 << 7
    DRIVE_NOT_READY = 1 << 17
    INVALID_FREQUENCY = 1 << 22
    INVALID_ACCELERATION = 1 << 23
    INVALID_DECELERATION = 1 << 24
    COMMAND_REJECTED = 1 << 25
    INVALID_DIRECTION = 1 << 26
