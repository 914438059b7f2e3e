"""The state of a CAN bus that both ways through its model work on: bit times, members, faults, and counters.

Time is kept in ticks that divide both bit times, so no rounding adds up.
"""

from collections.abc import Iterable
from fractions import Fraction
from math import lcm
from typing import Final

from fieldrig.clock import S
from fieldrig_bus.can.arbitration import priority
from fieldrig_bus.can.faults import Faults
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import INTERMISSION_BITS, classical_bits, fd_bits
from fieldrig_bus.can.load import Load
from fieldrig_bus.can.member import Member, Request

NEVER: Final = 1 << 80
"""A tick that never comes."""


class Medium:
    """One bus.  Without a bit rate, bits take no time (`nominal` is 0)."""

    __slots__ = (
        "arbitration_lost", "bitrate", "bits", "departed", "error_frames", "faults", "frames", "free", "intermission",
        "is_acknowledged", "load", "lost", "members", "nominal", "per_ns", "switched",
    )  # fmt: skip

    def __init__(self, bitrate: int | None, data_bitrate: int | None, *, is_acknowledged: bool) -> None:
        nominal = Fraction(S, bitrate) if bitrate is not None else Fraction(0)
        switched = Fraction(S, data_bitrate) if data_bitrate is not None else nominal
        self.bitrate = bitrate
        self.is_acknowledged = is_acknowledged
        """Frames are acknowledged even if no other member is there."""
        self.per_ns = lcm(nominal.denominator, switched.denominator)
        """Ticks per nanosecond."""
        self.nominal = int(nominal * self.per_ns)
        """Ticks per bit."""
        self.switched = int(switched * self.per_ns)
        """Ticks per bit at the data bit rate."""
        self.intermission = INTERMISSION_BITS * self.nominal
        self.free = 0
        """The tick at which the bus is free after everything that has been collected."""
        self.members: dict[str, Member] = {}
        self.departed: list[Member] = []
        """Members that left while their frame was on the wire.  The frame is finished."""
        self.faults = Faults()
        self.load = Load(S * self.per_ns)
        self.frames = self.bits = self.lost = self.error_frames = self.arbitration_lost = 0

    def everybody(self) -> Iterable[Member]:
        """All members, and those that left while their frame was on the wire."""
        return (*self.members.values(), *self.departed)

    def request(self, asked: int, sender: Member, frame: CanFrame) -> Request:
        """Queue a frame that its sender asked for at tick `asked`."""
        if frame.is_fd:
            bits, switched = fd_bits(frame)
            ticks = bits * self.nominal + switched * self.switched
            bits += switched
        else:
            bits = classical_bits(frame)
            ticks = bits * self.nominal
        return Request(priority(frame), sender.order, asked, ticks, bits, sender, frame)

    def instant_ns(self, tick: int) -> int:
        """The instant of a tick, rounded up to the next nanosecond."""
        return -(-tick // self.per_ns)
