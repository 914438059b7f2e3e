"""Press: closes and opens on command, and reports every 100 ms.  An example of a device that is not part of fieldrig.

Made up, so here is its manual:

1. Identifier 0x201, to the press, 1 byte: 0 open, 1 close.  It ignores anything else.
2. Identifier 0x181, from the press, 3 bytes: state (0 open, 1 moving, 2 closed), position in 0.1 mm, little endian.
3. The wire `press.closed` is true while the press is closed.
"""

import struct
from collections.abc import Mapping
from enum import Enum
from typing import ClassVar

from pydantic import Field

from fieldrig import MS, Clock, Device, Link, Point, S, Settings, Timer
from fieldrig_bus.can import CanFrame
from fieldrig_bus.wires import Signal

COMMAND, REPORT = 0x201, 0x181
OPEN, CLOSE = b"\x00", b"\x01"
REPORT_PERIOD_NS = 100 * MS


class State(Enum):
    OPEN = 0
    MOVING = 1
    CLOSED = 2


class PressSettings(Settings):
    stroke_mm: float = Field(100, gt=0, le=6000, description="from open to closed")
    speed_mm_per_s: float = Field(50, gt=0, description="of the ram")


class Press(Device):
    about: ClassVar[str] = "a press that closes and opens on command"

    def __init__(self, clock: Clock, settings: PressSettings, can: Link[CanFrame], wires: Link[Signal]) -> None:
        self._clock, self._settings, self._can, self._wires = clock, settings, can, wires
        self._left_mm = self._target_mm = 0.0  # where the last move began, and where it ends
        self._left_ns = self._arrival_ns = 0
        self._arrival: Timer | None = None
        can.on_receive(self._on_command, interest=[(COMMAND, 0x7FF)])

    def start(self) -> None:
        self._tell_closed()
        self._report()

    def points(self) -> Mapping[str, Point]:
        return {
            "position": Point(self.position_mm, unit="mm", about="of the ram, 0 is open"),
            "state": Point(lambda: self.state().name),
        }

    def position_mm(self) -> float:
        now_ns = self._clock.now_ns()
        if now_ns >= self._arrival_ns:
            return self._target_mm
        way_mm = self._settings.speed_mm_per_s * (now_ns - self._left_ns) / S
        return self._left_mm + (way_mm if self._target_mm > self._left_mm else -way_mm)

    def state(self) -> State:
        if self._clock.now_ns() < self._arrival_ns:
            return State.MOVING
        return State.CLOSED if self._target_mm > 0 else State.OPEN

    def _on_command(self, frame: CanFrame) -> None:
        if frame.data == CLOSE:
            self._move_to(self._settings.stroke_mm)
        elif frame.data == OPEN:
            self._move_to(0.0)

    def _move_to(self, target_mm: float) -> None:
        self._left_mm, self._left_ns, self._target_mm = self.position_mm(), self._clock.now_ns(), target_mm
        way_mm = abs(target_mm - self._left_mm)
        self._arrival_ns = self._left_ns + round(way_mm / self._settings.speed_mm_per_s * S)
        if self._arrival is not None:
            self._arrival.cancel()
        self._arrival = self._clock.call_at(self._arrival_ns, self._tell_closed)
        self._tell_closed()

    def _tell_closed(self) -> None:
        self._wires.send(Signal("press.closed", self.state() is State.CLOSED))

    def _report(self) -> None:
        data = struct.pack("<BH", self.state().value, round(self.position_mm() * 10))
        self._can.send(CanFrame(REPORT, data))
        self._clock.call_at(self._clock.now_ns() + REPORT_PERIOD_NS, self._report)
