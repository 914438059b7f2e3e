"""The motion states of an axis (digest 6)."""

from enum import IntEnum


class State(IntEnum):
    """The numbers are those of the suggested register map."""

    STANDSTILL = 0
    DISCRETE_MOTION = 1
    CONTINUOUS_MOTION = 2
    STOPPING = 3
    ERROR_STOP = 4
