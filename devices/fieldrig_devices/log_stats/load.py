"""The load of a CAN bus in each second, from the bits that its frames take on the wire."""

from typing import Final

from fieldrig.clock import S
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import classical_bits, fd_bits

MOST_SECONDS: Final = 200_000
"""Seconds with traffic that are kept: more than two days."""


class Load:
    """The time that frames took in each second of the log."""

    def __init__(self, bitrate: int, data_bitrate: int) -> None:
        """Both bit rates are in bit/s; the second is that of the data of FD frames that switch."""
        self._bit_ns, self._data_bit_ns = S / bitrate, S / data_bitrate
        self._busy_ns: dict[int, float] = {}
        self.left_out = 0
        """Frames in seconds beyond the bound."""

    def add(self, time_ns: int, frame: CanFrame) -> None:
        """Count a frame for the second of its instant."""
        second = time_ns // S
        busy_ns = self._busy_ns.get(second)
        if busy_ns is None:
            if len(self._busy_ns) >= MOST_SECONDS:
                self.left_out += 1
                return
            busy_ns = 0.0
        if frame.is_fd:
            nominal, switched = fd_bits(frame)
            self._busy_ns[second] = busy_ns + nominal * self._bit_ns + switched * self._data_bit_ns
        else:
            self._busy_ns[second] = busy_ns + classical_bits(frame) * self._bit_ns

    def by_second(self) -> list[tuple[int, float]]:
        """Return seconds with traffic and their load, 1 for a bus that is never idle."""
        return [(second, busy_ns / S) for second, busy_ns in sorted(self._busy_ns.items())]

    def mean(self, duration_ns: int) -> float:
        """Return the load over the whole duration of a log; over its one second if it is shorter."""
        return sum(self._busy_ns.values()) / max(duration_ns, S)
