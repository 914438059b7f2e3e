"""A PAM's objects without a ring: a recorded port, a kernel that counts cycles, and ST1 nodes that carry out orders."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from fieldrig_devices.motion.profile import Limits, Profile, change_speed, keep, move
from fieldrig_devices.pam.language.compiler import checked
from fieldrig_devices.pam.objects.application import ApplicationObjects
from fieldrig_devices.pam.objects.axes_set import COMPARED
from fieldrig_devices.pam.runtime.item import RoutineRef
from fieldrig_devices.pamring.frames import (
    Answer,
    AxisOrder,
    AxisReport,
    EndOfPipe,
    InputChanged,
    Move,
    Order,
    Read,
    Report,
    SetPoint,
    SetPointMode,
)

SYNCHRONISED, IN_RUN = 1, 4
"""The bits of an axis's status for a pipe and for a run (table 12-4)."""


class Kernel:
    def __init__(self, thirds: int = 3) -> None:
        self.thirds = thirds
        self.cycle_number = 0
        self.touched_names: set[str] = set()
        self.routines: list[RoutineRef] = []
        self.reports: list[tuple[str, tuple[int, ...]]] = []

    def touched(self, name: str) -> None:
        self.touched_names.add(name)

    def start_routine(self, routine: RoutineRef) -> None:
        self.routines.append(routine)

    def report(self, code: str, details: Sequence[int] = ()) -> None:
        self.reports.append((code, tuple(details)))


class Port:
    """It keeps what was sent, by address; a negative address is a group."""

    def __init__(self) -> None:
        self.sent: list[tuple[int, Order]] = []

    def send(self, address: int, order: Order) -> None:
        self.sent.append((address, order))

    def send_to_group(self, group: int, order: Order) -> None:
        self.sent.append((-group, order))


class St1:
    """The axis of a node: its own part by trapezoids, and the part of a pipe, in resolver units."""

    def __init__(self, send: Callable[[Report], None], cycle_s: float) -> None:
        self._send, self._cycle_s = send, cycle_s
        self.base, self.way, self.cycles = 0.0, keep(0.0), 0
        self.pipe = 0.0
        self.mode: SetPointMode | None = None
        self._runs = False
        self.number = self.done = 0
        self.limits = Limits(math.inf, math.inf, math.inf)
        self.registers = dict.fromkeys(COMPARED, 0)
        """The register 0 is that of the main resolver."""

    @property
    def own(self) -> float:
        return self.base + self.way.values_at(self.cycles * self._cycle_s)[0]

    @property
    def position(self) -> float:
        return self.own + self.pipe

    def order(self, order: Order) -> None:
        match order:
            case AxisOrder():
                self._order(order)
            case SetPoint(SetPointMode.POSITION, value):
                if self.mode is None:
                    self.base, self.way = 0.0, keep(0.0)
                self.mode, self.pipe = SetPointMode.POSITION, value
            case SetPoint(SetPointMode.SPEED):
                self.mode = SetPointMode.SPEED
            case EndOfPipe():
                self.base, self.way, self.cycles = self.position, keep(0.0), 0
                self.mode, self.pipe = None, 0.0
            case Read(request, register):
                self._send(Answer(request, self.registers.get(register)))

    def _order(self, order: AxisOrder) -> None:
        self.number = order.number or self.number
        self._runs = order.move is Move.RUN and order.value != 0
        speed = self.way.values_at(self.cycles * self._cycle_s)[1]
        wanted = (order.speed or 1, order.acceleration or 1, order.deceleration or 1)
        limits = Limits(*map(min, self.limits, wanted))
        way: Profile | None = None
        match order.move:
            case Move.ABSOLUTE_MOVE:
                way = move(order.value - self.own, speed, limits)
            case Move.RELATIVE_MOVE:
                way = move(order.value, speed, limits)
            case Move.RUN:
                way = change_speed(speed, max(min(order.value, self.limits.speed), -self.limits.speed), limits)
            case Move.STOP:
                way = change_speed(speed, 0, limits)
                self.base += self.pipe
                self.mode, self.pipe = None, 0.0
            case Move.POSITION:
                self.base += order.value - self.position
            case Move.POWER_ON:
                self.base, self.way = 0.0, keep(0.0)
        if way is not None:
            self.base, self.way, self.cycles = self.own, way, 0

    def cycle(self) -> None:
        self.cycles += 1
        if self.done != self.number and self.cycles * self._cycle_s >= self.way.duration_s:
            self.done = self.number
            status = (SYNCHRONISED if self.mode is not None else 0) | (IN_RUN if self._runs else 0)
            self._send(AxisReport(status, 0, self.done, round(self.own)))


class Bench:
    """An application's objects on the bench; a cycle is what the PAM does in a basic cycle."""

    def __init__(self, text: str, **settings: Any) -> None:
        program, mistakes = checked(text, "bench.pam")
        assert [str(wrong) for wrong in mistakes if not wrong.is_note] == []
        thirds = int(next(p.values[0].value for p in program.items[0].parameters if p.name == "BASIC_PAM_CYCLE"))  # type: ignore[union-attr]
        self.kernel, self.port = Kernel(thirds), Port()
        self.objects = ApplicationObjects(program, self.kernel, self.port, **settings)
        self.cycle_s = thirds / 3000
        self.nodes: dict[int, St1] = {}
        self._reports: list[tuple[int, Report]] = []
        self.delivered = 0

    def item(self, name: str, index: int = 0) -> Any:
        return self.objects.items[name][index]

    def ask(self, name: str, function: str, *arguments: Any) -> Any:
        return self.item(name).ask(function, arguments)

    def do(self, name: str, function: str, *arguments: Any) -> None:
        self.item(name).do(function, arguments)

    def connect(self, *names: str) -> None:
        self.objects.connect([self.item(name) for name in names])

    def st1(self, *addresses: int) -> None:
        """Put nodes on the ring."""
        for address in addresses:
            self.nodes[address] = St1(lambda report, to=address: self.report(to, report), self.cycle_s)  # type: ignore[misc]

    def report(self, address: int, report: Report) -> None:
        """Lay a report into the ring, for the next cycle."""
        self._reports.append((address, report))

    def change(self, address: int, item: int, value: int, age_us: int = 0) -> None:
        self.objects.on_report(address, InputChanged(item, value, age_us))

    def cycle(self, number: int = 1, work: Callable[[], None] = lambda: None) -> None:
        """Go on for basic cycles; `work` is that of the programs."""
        for _ in range(number):
            reports, self._reports = self._reports, []
            for address, report in reports:
                self.objects.on_report(address, report)
            self.kernel.cycle_number += 1
            self.objects.take()
            self.objects.flow()
            work()
            self.objects.give()
            for address, order in self.port.sent[self.delivered :]:
                if address in self.nodes:
                    self.nodes[address].order(order)
            self.delivered = len(self.port.sent)
            for node in self.nodes.values():
                node.cycle()

    def until(self, condition: Callable[[], bool], most: int = 200_000) -> int:
        """Go on until a condition is true, and return the number of cycles."""
        for number in range(most):
            if condition():
                return number
            self.cycle()
        raise AssertionError("the condition does not get true")

    def sent(self, address: int) -> list[Order]:
        return [order for to, order in self.port.sent if to == address]

    def set_points(self, address: int) -> list[int]:
        return [order.value for order in self.sent(address) if isinstance(order, SetPoint)]
