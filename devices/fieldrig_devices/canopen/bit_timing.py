"""The bit rates that LSS can configure (CiA 305)."""

from typing import Final

BIT_RATES: Final = {0: 1_000_000, 1: 800_000, 2: 500_000, 3: 250_000, 4: 125_000, 6: 50_000, 7: 20_000, 8: 10_000}
"""Bit rates in bit/s by index of the standard table 0."""
