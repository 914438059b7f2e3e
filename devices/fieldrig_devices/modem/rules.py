"""The rules of a call by the settings of a modem: X, and for its offer in the handshake +MS, N and +ES.

With automatic modulation (N1, and the second field of +MS), every slower modulation is offered as well.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final, Literal

from fieldrig_bus.serial.message import Format
from fieldrig_bus.telephone.message import Offer
from fieldrig_bus.telephone.modulation import NONE, OPTIONAL, RATES, REQUIRED, Modulation
from fieldrig_devices.modem.call import Rules
from fieldrig_devices.modem.profile import Profile

ANSWERED: Final = {0: NONE, 1: NONE, 2: OPTIONAL, 4: REQUIRED, 5: REQUIRED}
"""Error correction of calls that come, by the third field of +ES."""


@dataclass(frozen=True)
class Build:
    """The fixed properties of a modem."""

    baud: int
    highest_bps: int
    training_ns: int
    is_rockwell: bool
    is_paced: bool


def rules_of(profile: Profile, build: Build, register: Callable[[int], int], *, is_answering: bool) -> Rules:
    """Return the rules of a call that begins now; `register` returns the value of an S register."""
    dialling = profile.settings["X"]
    return Rules(
        offer_of(profile, build.highest_bps, is_answering=is_answering),
        build.training_ns,
        register,
        is_blind=dialling in (0, 1, 3),
        detects_busy=dialling in (3, 4),
    )


FORMATS: Final[dict[int, tuple[Literal[7, 8], bool, Literal[1, 2]]]] = {
    1: (8, False, 2), 2: (8, True, 1), 3: (8, False, 1), 4: (7, False, 2), 5: (7, True, 1), 6: (7, False, 1),
}  # fmt: skip
"""Data bits, parity and stop bits by the first field of +ICF (V.250, 6.2.11); 0 follows the terminal."""


def fixed_form(theirs: Format, profile: Profile) -> Format:
    """Return the format of the serial line: the terminal's, but for what +IPR and +ICF have fixed."""
    form = replace(theirs, baud=int(profile.parameters["+IPR"][0]) or theirs.baud)
    format_code, parity = profile.parameters["+ICF"]
    if format_code == 0:
        return form
    data_bits, has_parity, stop_bits = FORMATS[int(format_code)]
    sign: Literal["N", "E", "O"] = ("E" if parity else "O") if has_parity else "N"
    return replace(form, data_bits=data_bits, parity=sign, stop_bits=stop_bits)


def correction_of(profile: Profile, *, is_answering: bool) -> int:
    """Return the error correction that +ES asks for (V.250, 6.5.1)."""
    request, necessity, answered = (int(value) for value in profile.parameters["+ES"])
    if is_answering:
        return ANSWERED[answered]
    if request in (0, 1):
        return NONE
    return REQUIRED if necessity else OPTIONAL


def offer_of(profile: Profile, highest_bps: int, *, is_answering: bool) -> Offer:
    """Return the offer of a modem that can do `highest_bps`."""
    carrier, automode, lowest, *_ = profile.parameters["+MS"]
    limits = [int(profile.parameters["+MS"][field]) for field in (3, 5)]
    highest = min([highest_bps, *(limit for limit in limits if limit)])
    lowest = max(int(lowest), int(profile.parameters["+MS"][4]))
    names = list(RATES)[list(RATES).index(str(carrier)) :]
    if not (automode and profile.settings["N"]):
        names = names[:1]
    modulations = tuple(Modulation(name, lowest, highest) for name in names)
    return Offer(modulations, correction_of(profile, is_answering=is_answering))
