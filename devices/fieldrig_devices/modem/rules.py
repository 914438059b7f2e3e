"""The rules of a call by the settings of a modem: X, and for its offer in the handshake +MS, N and \\N.

With automatic modulation (N1, and the second field of +MS), every slower modulation is offered as well.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

from fieldrig_bus.telephone.message import Offer
from fieldrig_bus.telephone.modulation import NONE, OPTIONAL, RATES, REQUIRED, Modulation
from fieldrig_devices.modem.call import Rules
from fieldrig_devices.modem.profile import Profile

CORRECTION: Final = {0: NONE, 1: NONE, 2: REQUIRED, 3: OPTIONAL, 4: REQUIRED, 5: OPTIONAL}
"""Error correction by the value of \\N."""


@dataclass(frozen=True)
class Build:
    """The fixed properties of a modem."""

    baud: int
    highest_bps: int
    training_ns: int
    is_rockwell: bool
    is_paced: bool


def rules_of(profile: Profile, build: Build, register: Callable[[int], int]) -> Rules:
    """Return the rules of a call that begins now; `register` returns the value of an S register."""
    dialling = profile.settings["X"]
    return Rules(
        offer_of(profile, build.highest_bps),
        build.training_ns,
        register,
        is_blind=dialling in (0, 1, 3),
        detects_busy=dialling in (3, 4),
    )


def offer_of(profile: Profile, highest_bps: int) -> Offer:
    """Return the offer of a modem that can do `highest_bps`."""
    carrier, automode, lowest, *_ = profile.parameters["+MS"]
    limits = [int(profile.parameters["+MS"][place]) for place in (3, 5)]
    highest = min([highest_bps, *(limit for limit in limits if limit)])
    lowest = max(int(lowest), int(profile.parameters["+MS"][4]))
    names = list(RATES)[list(RATES).index(str(carrier)) :]
    if not (automode and profile.settings["N"]):
        names = names[:1]
    modulations = tuple(Modulation(name, lowest, highest) for name in names)
    return Offer(modulations, CORRECTION[profile.settings["\\N"]])
