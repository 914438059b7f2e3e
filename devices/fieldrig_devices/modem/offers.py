"""The offer of a modem in the handshake, by its settings: +MS, N and \\N.

With automatic modulation (N1, and the second field of +MS), every slower modulation is offered as well.
"""

from typing import Final

from fieldrig_bus.telephone.message import Offer
from fieldrig_bus.telephone.modulation import NONE, OPTIONAL, RATES, REQUIRED, Modulation
from fieldrig_devices.modem.profile import Profile

CORRECTION: Final = {0: NONE, 1: NONE, 2: REQUIRED, 3: OPTIONAL, 4: REQUIRED, 5: OPTIONAL}
"""Error correction by the value of \\N."""


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
