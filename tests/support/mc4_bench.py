"""Benches for the MC-4: its enable chain on a motor whose speed the test says."""

from collections.abc import Callable
from dataclasses import dataclass, field

from fieldrig.clock import MS
from fieldrig_devices.mc4.diagnosis import LIMITS, Diagnosis
from fieldrig_devices.mc4.enable import EnableChain, Limit, Seen, Stage, Times

N_MIN_RPM = 10.0
Speed = Callable[[int], float]
"""In rpm, by ms."""


@dataclass(frozen=True)
class Line:
    """What can be seen from outside at one instant."""

    at_ms: int
    brake_closed: bool
    torque: bool
    ready: bool
    axis_state: int
    mc4_state: int
    code: int


@dataclass
class ChainBench:
    """Time goes on by a millisecond; what changes is traced."""

    times: Times = field(default_factory=Times)
    speed: Speed = lambda _: 0.0
    hardware: bool = True
    controller: bool = True
    can_start: bool = True
    is_at_overload_position: bool = False

    def __post_init__(self) -> None:
        self.chain = EnableChain(self.times, self._on_limit)
        self.diagnosis = Diagnosis(lambda reaction: self.chain.react(self.ms * MS, reaction))
        self.ms = 0
        self.trace: list[Line] = []
        self._look()

    def _on_limit(self, limit: Limit) -> None:
        self.diagnosis.raise_(LIMITS[limit])

    def _look(self) -> None:
        is_slow = abs(self.speed(self.ms)) < N_MIN_RPM
        seen = Seen(self.hardware, self.controller, self.can_start, is_slow, self.is_at_overload_position)
        self.chain.update(self.ms * MS, seen)
        chain = self.chain
        line = Line(
            self.ms,
            chain.is_brake_lifted,
            chain.has_torque,
            chain.is_ready,
            chain.axis_state,
            chain.mc4_state,
            self.diagnosis.code,
        )
        if not self.trace or self._seen(line) != self._seen(self.trace[-1]):
            self.trace.append(line)

    @staticmethod
    def _seen(line: Line) -> tuple[object, ...]:
        return (line.brake_closed, line.torque, line.ready, line.axis_state, line.mc4_state, line.code)

    def stage(self) -> Stage:
        return self.chain.stage

    def look(self) -> None:
        """Now, at once."""
        self._look()

    def run(self, ms: int) -> None:
        for _ in range(ms):
            self.ms += 1
            self._look()

    def quit(self) -> bool:
        if not self.chain.can_quit or not self.diagnosis.quit():
            return False
        self.chain.quit(self.ms * MS)
        self._look()
        return True

    def start(self) -> None:
        """Until it is controlled; the trace begins anew, at 0 ms."""
        self.run(self.times.brake_disconnection_ns // MS + 1)
        assert self.chain.stage is Stage.CONTROLLED
        self.ms = 0
        self.trace.clear()
        self._look()
