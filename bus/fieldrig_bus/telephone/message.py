"""Messages of the telephone network: what a subscriber does and hears, and what two modems tell each other.

A receiver gets all messages, unless its interest names "signals" or "data" alone.
"""

from dataclasses import dataclass
from enum import IntEnum
from typing import Any, Final

from fieldrig.bus import words_of
from fieldrig_bus.telephone.modulation import FASTEST_BPS, NONE, RATES, REQUIRED, Agreed, Modulation
from fieldrig_bus.telephone.modulation import common_correction as _common_correction
from fieldrig_bus.telephone.modulation import common_modulation as _common_modulation


class Tone(IntEnum):
    """Tones that a subscriber hears from the exchange."""

    SILENCE = 0
    DIAL = 1
    RINGING = 2
    BUSY = 3
    UNOBTAINABLE = 4


@dataclass(frozen=True, slots=True)
class Hook:
    """The subscriber seizes the line (`is_off`), which also answers a call, or leaves it, which ends a call."""

    is_off: bool


@dataclass(frozen=True, slots=True)
class Dial:
    """Digits that the subscriber has dialled, by tones or pulses."""

    digits: str


@dataclass(frozen=True, slots=True)
class Ring:
    """The ringing voltage of the exchange goes on or off; `caller` is the number of the caller, if it has one."""

    is_on: bool
    caller: str = ""


@dataclass(frozen=True, slots=True)
class Heard:
    """A tone of the exchange."""

    tone: Tone


@dataclass(frozen=True, slots=True)
class Offer:
    """The abilities of a modem, as it states them in the handshake."""

    modulations: tuple[Modulation, ...]
    correction: int = NONE
    """`NONE`, `OPTIONAL` or `REQUIRED`."""
    line_bps: int = FASTEST_BPS
    """The highest rate that the line carries; the network lowers it."""


@dataclass(frozen=True, slots=True)
class Carrier:
    """The carrier of the other end, from its sender on at this rate.  A rate of 0 is the loss of the carrier."""

    bps: int
    is_corrected: bool = False
    is_paced: bool = True
    """False if the network carries data in no time; the network sets it."""


@dataclass(frozen=True, slots=True)
class Ready:
    """A modem that corrects errors can, or cannot, take data at present (RR and RNR of V.42)."""

    is_ready: bool


TelephoneMessage = bytes | Hook | Dial | Ring | Heard | Offer | Carrier | Ready

KINDS: Final[dict[type, str]] = {
    bytes: "data", Hook: "signals", Dial: "signals", Ring: "signals", Heard: "signals", Offer: "signals",
    Carrier: "signals", Ready: "signals",
}  # fmt: skip
"""The word of an interest for each kind of message."""
DIGITS: Final = frozenset("0123456789ABCD*#")
MOST_DIGITS: Final = 64


def agreed(ours: Offer, theirs: Offer) -> Agreed | None:
    """Return how two modems connect; None if they cannot."""
    common = _common_modulation(ours.modulations, theirs.modulations, min(ours.line_bps, theirs.line_bps))
    is_corrected = _common_correction(ours.correction, theirs.correction)
    return None if common is None or is_corrected is None else Agreed(*common, is_corrected)


def check_sent(message: Any) -> None:
    """Raise TypeError or ValueError for a message that no subscriber can send."""
    match message:
        case Ring() | Heard():
            raise ValueError("only the exchange rings and gives tones")
        case _:
            check(message)


def check(message: Any) -> None:
    """Raise TypeError or ValueError for a message that cannot be on the network."""
    if type(message) is bytes:
        return
    match message:
        case Hook():
            _check_type("is_off", message.is_off, bool)
        case Dial():
            _check_type("digits", message.digits, str)
            if not 1 <= len(message.digits) <= MOST_DIGITS or not DIGITS.issuperset(message.digits):
                raise ValueError(f"digits {message.digits!r}: expected 1 to {MOST_DIGITS} of {''.join(sorted(DIGITS))}")
        case Ring():
            _check_type("is_on", message.is_on, bool)
            _check_type("caller", message.caller, str)
            if len(message.caller) > MOST_DIGITS or not DIGITS.issuperset(message.caller):
                raise ValueError(f"caller {message.caller!r}: expected digits")
        case Heard():
            _check_type("tone", message.tone, Tone)
        case Offer():
            _check_offer(message)
        case Carrier():
            _check_number("bps", message.bps, 0, FASTEST_BPS)
            _check_type("is_corrected", message.is_corrected, bool)
            _check_type("is_paced", message.is_paced, bool)
        case Ready():
            _check_type("is_ready", message.is_ready, bool)
        case _:
            expected = "bytes, Hook, Dial, Offer, Carrier or Ready"
            raise TypeError(f"expected {expected}, found {type(message).__name__}")


def check_interest(interest: Any) -> None:
    """Raise TypeError or ValueError for an interest in anything but "signals" and "data"."""
    for word in words_of(interest):
        if word not in ("signals", "data"):
            raise ValueError(f"interest {word!r} on a telephone network: expected 'signals' or 'data'")


def _check_offer(offer: Offer) -> None:
    _check_type("modulations", offer.modulations, tuple)
    if len(offer.modulations) > len(RATES):
        raise ValueError(f"{len(offer.modulations)} modulations: expected at most {len(RATES)}")
    for modulation in offer.modulations:
        _check_type("modulations", modulation, Modulation)
        _check_type("name", modulation.name, str)
        if modulation.name not in RATES:
            raise ValueError(f"modulation {modulation.name!r}: expected one of {list(RATES)}")
        _check_number("lowest_bps", modulation.lowest_bps, 0, FASTEST_BPS)
        _check_number("highest_bps", modulation.highest_bps, 0, FASTEST_BPS)
    _check_number("correction", offer.correction, NONE, REQUIRED)
    _check_number("line_bps", offer.line_bps, 0, FASTEST_BPS)


def _check_type(name: str, value: Any, expected: type) -> None:
    if type(value) is not expected:
        raise TypeError(f"{name}: expected {expected.__name__}, found {type(value).__name__}")


def _check_number(name: str, value: Any, lowest: int, highest: int) -> None:
    _check_type(name, value, int)
    if not lowest <= value <= highest:
        raise ValueError(f"{name} {value}: expected {lowest} to {highest}")
