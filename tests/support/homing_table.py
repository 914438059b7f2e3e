"""The homing methods of CiA 402-2 as its figures show them, on one machine for all benches.

Switches are at -300 000 and 400 000, and the home switch is closed from 0 to 100 000; the encoder has a zero at each
multiple of 70 000.  Each case is a method, where the axis begins, and the home that it finds.
"""

from typing import Final

NEGATIVE, POSITIVE, HOME_BEGINS, HOME_ENDS = -300_000, 400_000, 0, 100_000
REVOLUTION: Final = 70_000
BEGINS: Final = (-350_000, -100_000, 50_000, 200_000, 450_000)
"""On the negative limit switch, below, on, and above the home switch, on the positive limit switch."""

EDGES: Final[tuple[tuple[int, int, int], ...]] = (
    (17, 0, NEGATIVE),
    (17, -310_000, NEGATIVE),
    (18, 0, POSITIVE),
    (18, 410_000, POSITIVE),
    (19, -100_000, HOME_BEGINS),
    (19, 50_000, HOME_BEGINS),
    (20, -100_000, HOME_BEGINS),
    (20, 50_000, HOME_BEGINS),
    (21, 200_000, HOME_ENDS),
    (21, 50_000, HOME_ENDS),
    (22, 200_000, HOME_ENDS),
    (22, 50_000, HOME_ENDS),
    *((method, begin, HOME_BEGINS) for method in (23, 24, 29, 30) for begin in BEGINS),
    *((method, begin, HOME_ENDS) for method in (25, 26, 27, 28) for begin in BEGINS),
)
"""The edge of a switch that each method finds."""
ZEROS: Final[tuple[tuple[int, int, int], ...]] = (
    (1, 0, -280_000),  # the first one above the negative limit switch
    (2, 0, 350_000),
    (3, -100_000, -70_000),  # the first one below the edge at 0
    (4, -100_000, 70_000),
    (5, 200_000, 140_000),
    (6, 200_000, 70_000),
    *((method, begin, -70_000) for method in (7, 14) for begin in BEGINS),
    *((method, begin, 70_000) for method in (8, 13) for begin in BEGINS),
    *((method, begin, 70_000) for method in (9, 12) for begin in BEGINS),
    *((method, begin, 140_000) for method in (10, 11) for begin in BEGINS),
    (33, 100, 0),
    (33, -100, -70_000),
    (34, 100, 70_000),
    (34, -100, 0),
    (34, 0, 70_000),
    (33, 0, -70_000),
)
"""The zero of the encoder that each method finds."""
WITHOUT_MOVES: Final = ((35, 1_234, 1_234), (37, 1_234, 1_234))


def switches(position: int) -> int:
    """Return the inputs of the machine as in 60FDh."""
    return (position <= NEGATIVE) | (position >= POSITIVE) << 1 | (HOME_BEGINS <= position <= HOME_ENDS) << 2
