"""The limits of the MAx-4 for a project, as settings (PacDrive manual 6020 to 6058, digest 1.16)."""

from dataclasses import dataclass

KILOBYTE = 1024


@dataclass(frozen=True, slots=True)
class Limits:
    tasks: int = 64
    """PD-310; PD-063 has 127, the data table has 64 (X2)."""
    variables: int = 2 * 1024 * KILOBYTE - 3 * 64 * KILOBYTE
    """Bytes of all variables: the data area without the three areas of 64 kByte (PD-312, PD-313)."""
    area: int = 64 * KILOBYTE
    """Bytes of each of %I, %Q and %M (PD-314)."""
    retain: int = 101 * KILOBYTE
    """Bytes of RETAIN variables: 1 kByte of NVRAM, 64 kByte of flash with a UPS, 101 kByte with a PN-4 (PD-315)."""
    variable: int = 128 * KILOBYTE
    """Bytes of an array, a structure, a list of global variables, or an instance (PD-316)."""
    stack: int = 10 * KILOBYTE
    """Bytes of the variables of functions that call one another (PD-317)."""
    if_depth: int = 15
    """PD-318."""


MAX_4 = Limits()
BELOW_V00_12 = Limits(variable=32 * KILOBYTE)
"""Firmware below V00.12.00 (PD-316)."""
