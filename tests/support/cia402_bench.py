"""A CANopen node with one CiA 402 axis (or several) on a bench: frames and SDO, and a motor that obeys at once."""

from collections.abc import Callable
from math import inf
from typing import Any, Self

from canopen_bench import CanopenBench, parse, show

from fieldrig.clock import MS, S
from fieldrig.storage.store import Store
from fieldrig_devices.cia402.axis import Cia402Axis
from fieldrig_devices.cia402.motor import Captured, Kind
from fieldrig_devices.max4.can.objects import EDS

__all__ = ["Cia402Bench", "FakeMotor", "parse", "show"]

CYCLE_NS = 4 * MS
NODE = 5
READY, ON, ENABLED = 0x21, 0x23, 0x27
"""Bits 0 to 3, 5 and 6 of the status word."""


class FakeMotor:
    """A motor at the position commanded in the cycle before, less `lag` increments."""

    def __init__(self) -> None:
        self.kinds = frozenset(Kind)
        self.is_there = self.is_ready = True
        self.is_following = self.is_stopping = self.has_warning = False
        self.errors: tuple[int, ...] = ()
        self.position, self.velocity, self.torque = 0, 0.0, 0
        self.rated_torque_mnm = 2_500
        self.rated_current_ma = 5_000
        self.torque_by_current = 1.0
        self.dc_link_mv = 325_000
        self.largest_speed = inf
        self.edges: dict[int, Captured] = {}
        self.revolution = 1_000_000
        self.lag = 0
        self.switches: Callable[[int], int] = lambda position: 0
        self.lifting = 0
        """Cycles that enabling takes."""
        self.outputs = 0
        self.most_torque: int | None = None
        self.will_reset = True
        self.wanted: list[bool] = []
        self._is_enabled = False
        self._rest = 0

    @property
    def current(self) -> int:
        return self.torque

    @property
    def inputs(self) -> int:
        return self.switches(self.position)

    def captured(self, bit: int) -> Captured | None:
        return self.edges.get(bit)

    def enable(self, is_on: bool) -> None:
        self.wanted.append(is_on)
        self._is_enabled, self._rest = is_on, self.lifting
        self.is_following = is_on and self.lifting == 0

    def limit_torque(self, most: int) -> None:
        self.most_torque = most

    def set_outputs(self, outputs: int, mask: int) -> None:
        self.outputs = outputs & mask

    def reset(self, done: Callable[[], None]) -> None:
        if self.will_reset:
            self.errors = ()
        done()

    def cycle(self, kind: Kind, value: float) -> None:
        if self._is_enabled and not self.is_following:
            self._rest -= 1
            self.is_following = self._rest <= 0
        if not self.is_following:
            self.velocity = 0.0
        elif kind is Kind.POSITION:
            before, self.position = self.position, round(value) - self.lag
            self.velocity = (self.position - before) * S / CYCLE_NS
        elif kind is Kind.VELOCITY:
            self.velocity = value
            self.position += round(value * CYCLE_NS / S)
        else:
            self.torque = round(value)


class ByObject(CanopenBench):
    """A bench whose objects are read and written by SDO."""

    def put(self, index: int, value: int, sub: int = 0, axis: int = 0) -> Self:
        """Write an object by SDO; AssertionError with the abort code if it is refused."""
        answer = self.try_put(index, value, sub, axis)
        assert answer == "", answer
        return self

    def try_put(self, index: int, value: int, sub: int = 0, axis: int = 0) -> str:
        """The abort code, "" if it was taken."""
        at = index + axis * 0x800
        variable = self.node.dictionary.find(at, sub)
        size = variable.type.size or 4
        data = (value & ((1 << 8 * size) - 1)).to_bytes(4, "little").hex(" ")
        head = {1: "2f", 2: "2b", 4: "23"}[size]
        answer = self.sdo(f"{head} {at & 0xFF:02x} {at >> 8:02x} {sub:02x} {data}")
        if answer[:2] == "80":
            return bytes.fromhex(answer[12:])[::-1].hex()
        assert answer[:2] == "60", answer
        return ""

    def try_get(self, index: int, sub: int = 0) -> int | None:
        """The value; None if there is no such object."""
        return None if self.node.dictionary.get(index, sub) is None else self.get(index, sub)

    def get(self, index: int, sub: int = 0, axis: int = 0) -> int:
        at = index + axis * 0x800
        answer = bytes.fromhex(self.sdo(f"40 {at & 0xFF:02x} {at >> 8:02x} {sub:02x} 00 00 00 00"))
        size = {0x4F: 1, 0x4B: 2, 0x43: 4}[answer[0]]
        is_signed = self.node.dictionary.find(at, sub).type.low != 0
        return int.from_bytes(answer[4 : 4 + size], "little", signed=is_signed)

    def control(self, word: int, axis: int = 0) -> Self:
        return self.put(0x6040, word, axis=axis)

    def status(self, mask: int = 0xFFFF, axis: int = 0) -> int:
        return self.get(0x6041, axis=axis) & mask


class Cia402Bench(ByObject):
    """Node 5, operational, with as many axes as wanted."""

    def __init__(self, axes: int = 1, store: Store | None = None, **settings: Any) -> None:
        self.motors = [FakeMotor() for _ in range(axes)]
        self.axes: list[Cia402Axis] = []
        super().__init__(EDS, store, **settings)
        for number, motor in enumerate(self.motors):
            self.axes.append(Cia402Axis(self.clock, self.node.dictionary, number, motor, CYCLE_NS))
            self.node.attach(self.axes[-1])
        self.node.start()
        self.send("000#01 05")
        self.cycles(1)
        self.take()

    @property
    def motor(self) -> FakeMotor:
        return self.motors[0]

    @property
    def axis(self) -> Cia402Axis:
        return self.axes[0]

    def cycles(self, count: int) -> "Cia402Bench":
        for _ in range(count):
            self.clock.advance_to(self.clock.now_ns() + CYCLE_NS)
            for axis, motor in zip(self.axes, self.motors, strict=True):
                axis.step()
                motor.cycle(axis.drive.kind, axis.drive.set_value)
            for variable, read in self.node.watched:
                variable.set(read())
        self.clock.advance_to(self.clock.now_ns())
        return self

    def cycles_until(self, is_so: Callable[[], bool], most: int = 20_000) -> int:
        """How many cycles it takes."""
        for count in range(most):
            if is_so():
                return count
            self.cycles(1)
        raise AssertionError("it doesn't come")

    def enabled(self, mode: int) -> "Cia402Bench":
        """Enable operation in this mode."""
        self.put(0x6060, mode).control(0x06).control(0x07).control(0x0F).cycles(1)
        assert self.status(0x6F) == ENABLED
        return self
