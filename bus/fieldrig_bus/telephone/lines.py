"""The lines and calls of a telephone network, as the exchange keeps them."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from fieldrig.clock import NEVER_NS
from fieldrig_bus.telephone.faults import TelephoneFault
from fieldrig_bus.telephone.message import Carrier
from fieldrig_bus.telephone.transmitter import Transmitter

EVERYTHING = frozenset({"signals", "data"})


@dataclass(frozen=True)
class Network:
    """The properties of a network; `numbers` are those of its members."""

    numbers: Mapping[str, str]
    highest_bps: int
    delay_ns: int
    ring_on_ns: int
    ring_off_ns: int
    outside_prefix: str
    is_paced: bool
    faults: Sequence[TelephoneFault] = ()


@dataclass(eq=False, slots=True)
class Line:
    """The line of one member."""

    member: str
    number: str
    transmitter: Transmitter
    interest: frozenset[str] = frozenset()
    is_off: bool = False
    """The line is seized: off hook."""
    digits: str = ""
    has_dial_tone: bool = False
    """The exchange takes digits."""
    waits_for_tone: bool = False
    """It is seized, and a fault keeps the dial tone from it."""
    call: "Call | None" = None
    carrier: Carrier = field(default_factory=lambda: Carrier(0))
    """The carrier that its modem sends."""
    heard_ns: int = 0
    """The instant until which what its modem has said is on its way."""


@dataclass(eq=False, slots=True)
class Call:
    """A call from `caller` to `called`; it is over when its lines no longer have it."""

    caller: Line
    called: Line
    is_ringing: bool = False
    """The ringing voltage is on the called line from time to time."""
    is_answered: bool = False
    is_silent: bool = False
    """A drop-out hides the carriers."""
    over_ns: int = NEVER_NS
    """The instant at which the last of what was said before the end of the call arrives."""

    @property
    def members(self) -> tuple[str, str]:
        return self.caller.member, self.called.member

    def other(self, line: Line) -> Line:
        return self.called if line is self.caller else self.caller
