"""Modulations of telephone modems, their rates, and the rate at which two modems connect.

Source: the ITU-T recommendations after which the modulations are named; names as in `+MS` of ITU-T V.250, 6.4.1.
Left out: V.90 and V.92, which need a digital line at one end, and a rate that differs by direction.
"""

from typing import Final, NamedTuple

RATES: Final[dict[str, tuple[int, ...]]] = {
    "V34": tuple(range(2400, 33_601, 2400)),
    "V32B": (4800, 7200, 9600, 12_000, 14_400),
    "V32": (4800, 9600),
    "V22B": (1200, 2400),
    "V22": (1200,),
    "V21": (300,),
}
"""The rates of each modulation in bit/s; the modulation that modems prefer comes first."""
SLOWEST_BPS: Final = 300
FASTEST_BPS: Final = 33_600
NONE, OPTIONAL, REQUIRED = range(3)
"""Values of `Offer.correction`."""


class Modulation(NamedTuple):
    """A modulation that a modem offers, and the range of its rates in bit/s."""

    name: str
    lowest_bps: int
    highest_bps: int


class Agreed(NamedTuple):
    """The result of a handshake."""

    modulation: str
    bps: int
    is_corrected: bool


def everything(lowest_bps: int = SLOWEST_BPS, highest_bps: int = FASTEST_BPS) -> tuple[Modulation, ...]:
    """Return all modulations with a rate in this range."""
    return tuple(
        Modulation(name, lowest_bps, highest_bps)
        for name, rates in RATES.items()
        if any(lowest_bps <= bps <= highest_bps for bps in rates)
    )


def common_modulation(
    ours: tuple[Modulation, ...], theirs: tuple[Modulation, ...], line_bps: int
) -> tuple[str, int] | None:
    """Return the best modulation of both modems and its highest rate on a line that carries `line_bps`.

    None if the modems have none in common.
    """
    offered = {modulation.name: modulation for modulation in theirs}
    for name in RATES:
        mine = next((modulation for modulation in ours if modulation.name == name), None)
        other = offered.get(name)
        if mine is None or other is None:
            continue
        lowest = max(mine.lowest_bps, other.lowest_bps)
        highest = min(mine.highest_bps, other.highest_bps, line_bps)
        fitting = [bps for bps in RATES[name] if lowest <= bps <= highest]
        if fitting:
            return name, fitting[-1]
    return None


def common_correction(ours: int, theirs: int) -> bool | None:
    """Return whether both correct errors; None if one of them requires it and the other one cannot."""
    if ours != NONE and theirs != NONE:
        return True
    return None if REQUIRED in (ours, theirs) else False
