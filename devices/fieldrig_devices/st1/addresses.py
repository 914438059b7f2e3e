"""Addresses of the inputs and outputs of an ST1, and the numbers that they have on its boards (appendix D)."""

from typing import Final

INPUT_ADDRESSES: Final = {101: 0, 102: 1, **{201 + place: 16 + place for place in range(16)}}
OUTPUT_ADDRESSES: Final = {201 + place: 8 + place for place in range(8)}
