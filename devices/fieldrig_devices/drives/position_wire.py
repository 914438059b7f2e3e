"""A wire with the position of a shaft as a motion, published again when the extrapolated one is no longer near."""

from collections.abc import Callable
from typing import Final

from fieldrig_bus.wires import Motion, Signal

DECIMALS: Final = 6
"""Decimals of measured numbers outside a drive: far below what sensors show, and far above the last bits of the
model, in which the fold and the steps may differ."""
POSITION_DECIMALS: Final = 9
"""The same for positions in rad."""


class PositionWire:
    """The position of one shaft, in rad."""

    def __init__(self, wire: str, tolerance: float, send: Callable[[Signal], None]) -> None:
        """`tolerance` is the largest error of the extrapolated position before a new one is published, in rad."""
        self._wire, self._tolerance, self._send = wire, tolerance, send
        self.motion: Motion | None = None
        """The motion as last published."""

    def publish(self, now_ns: int, position: float, speed: float) -> None:
        last = self.motion
        if last is not None:
            is_near = abs(last.at(now_ns) - position) <= self._tolerance
            if is_near and (speed or not last.speed):
                return
        self.motion = Motion(self._wire, round(position, POSITION_DECIMALS), "rad", now_ns, round(speed, DECIMALS))
        self._send(self.motion)
