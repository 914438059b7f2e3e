"""Flags of SocketCAN that several formats use (linux/can.h)."""

from typing import Final

ERROR: Final = 0x2000_0000
"""CAN_ERR_FLAG, which marks an error frame; in a filter it is CAN_INV_FILTER."""
BIT_RATE_SWITCH: Final = 0x01
"""CANFD_BRS, the flag of an FD frame that switches its bit rate."""
