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
from fieldrig_bus.can.member import Member, Request


class Load:
    """The bus load over the last second: all of the present second, and the rest of the one before it."""

    __slots__ = ("_before", "_busy", "_now", "_second", "_start")

    def __init__(self, second: int) -> None:
        self._second = second  # ticks
        self._start = self._now = self._busy = self._before = 0

    def add(self, now: int, busy: int) -> None:
        """Add `busy` ticks that ended at tick `now`."""
        if now >= self._start + self._second:
            start = now - now % self._second
            self._before = self._busy if start == self._start + self._second else 0
            self._start, self._busy = start, 0
        self._busy += busy
        self._now = now

    def share(self) -> float:
        """The load, 0 to 1."""
        rest = 1 - (self._now - self._start) / self._second
        return min(1.0, (self._busy + self._before * max(0.0, rest)) / self._second)


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
