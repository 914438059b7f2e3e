"""Benches for the ST1: its program with a recorded end of the ring, cycle by cycle."""

from typing import Any, TypeVar

from fieldrig.clock import MS, VirtualClock
from fieldrig_devices.pamring.frames import (
    AxisItem,
    AxisOrder,
    AxisReport,
    EndOfPipe,
    Move,
    Order,
    Report,
    SetPoint,
    SetPointMode,
)
from fieldrig_devices.st1.program import Program
from fieldrig_devices.st1.servo import Servo
from fieldrig_devices.st1.settings import St1Settings
from fieldrig_devices.st1.shaft import TURN

R = TypeVar("R")
AXIS = 7
"""The item of the axis."""


class RecordedPort:
    """A node's end of the ring that keeps what was sent."""

    def __init__(self) -> None:
        self.sent: list[Report] = []

    def send(self, report: Report) -> None:
        self.sent.append(report)


class ProgramBench:
    """A node in operation, with a basic cycle of 1 ms.  Lengths are turns of the motor."""

    def __init__(self, *, period: float = 0.0, power: bool = True, **settings: Any) -> None:
        self.clock, self.port = VirtualClock(), RecordedPort()
        self.outputs: dict[int, bool] = {}
        self.settings = St1Settings(ring_address=1, **settings)
        self.program = Program(self.clock, self.settings, self.port, self.outputs.__setitem__)
        self.program.servo.start()
        self.program.boards.start()
        self.program.forget()
        assert self.program.accept(AxisItem(AXIS, 0, round(period * TURN)))
        self.number = 0
        if power:
            self.move(Move.POWER_ON)

    @property
    def servo(self) -> Servo:
        return self.program.servo

    def take(self, kind: type[R]) -> list[R]:
        """Return the reports of a kind since the last call; the others are dropped."""
        sent, self.port.sent = self.port.sent, []
        return [report for report in sent if isinstance(report, kind)]

    @property
    def report(self) -> AxisReport:
        """The last report of the axis."""
        return next(report for report in reversed(self.port.sent) if isinstance(report, AxisReport))

    # ---- orders

    def send(self, *orders: Order) -> "ProgramBench":
        for order in orders:
            self.program.order(order)
        return self

    def move(
        self, move: Move, value: float = 0.0, speed: float = 0.0, acceleration: float = 0.0, deceleration: float = 0.0
    ) -> int:
        """Give an order, and return its number."""
        is_logical = move in (Move.POSITION, Move.UPDATE_STATUS)
        self.number += 0 if is_logical else 1
        numbers = (round(number * TURN) for number in (value, speed, acceleration, deceleration))
        self.program.order(AxisOrder(0 if is_logical else self.number, move, *numbers))
        return self.number

    def point(self, value: float, mode: SetPointMode = SetPointMode.POSITION) -> "ProgramBench":
        """Send a set-point in a cycle of its own."""
        scale = 1000 if mode is SetPointMode.TORQUE else TURN
        self.program.order(SetPoint(mode, round(value * scale)))
        return self.cycle()

    def end(self, mode: SetPointMode = SetPointMode.POSITION) -> "ProgramBench":
        self.program.order(EndOfPipe(mode))
        return self

    # ---- time

    def cycle(self, number: int = 1) -> "ProgramBench":
        """Let basic cycles pass."""
        for _ in range(number):
            self.program.cycle()
            self.clock.advance_to(self.clock.now_ns() + MS)
        return self

    def run_to(self, ms: float) -> "ProgramBench":
        """Let time pass without cycles, as a node at rest has nothing to do in them."""
        self.clock.advance_to(round(ms * MS))
        return self

    def wait(self, ms: float) -> "ProgramBench":
        """Let a time pass without cycles."""
        return self.run_to(self.clock.now_ns() / MS + ms)

    # ---- where it is

    @property
    def position(self) -> float:
        """The position of the shaft, as the application names it."""
        servo = self.servo
        return servo.set.named(servo.shaft.position_at(self.clock.now_ns())) / TURN

    @property
    def motor(self) -> float:
        return self.servo.shaft.position_at(self.clock.now_ns()) / TURN

    @property
    def speed(self) -> float:
        return self.servo.shaft.speed_at(self.clock.now_ns()) / TURN

    @property
    def lag(self) -> float:
        return self.servo.shaft.lag_at(self.clock.now_ns()) / TURN
