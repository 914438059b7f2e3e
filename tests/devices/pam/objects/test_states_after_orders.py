"""States after orders: whatever the delays on the ring, no object of a PAM shows the state of the time before."""

from collections import deque
from collections.abc import Callable
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pam_objects import Bench
from pam_programs import HEADER
from smart_io_bench import SmartIoBench
from st1_bench import AXIS, ProgramBench

from fieldrig_devices.pam.objects.readings import ObjectReadings
from fieldrig_devices.pamring.frames import (
    AxisItem,
    AxisOrder,
    CounterItem,
    InputItem,
    KeyItem,
    KeyMode,
    MotorItem,
    MotorOrder,
    Move,
    Order,
    OutputItem,
    Report,
    SetOutput,
)
from fieldrig_devices.smart_io.items import MotorDrive
from fieldrig_devices.st1.set_position import Doing

APPLICATION = (
    HEADER
    + """
NODE NOD_Desk; ADDRESS = 41; TYPE = SMART_IO; END
BINARY_OUTPUT SBO_Inc; NODE = NOD_Desk; ADDRESS = 201; ACTIVE = HIGH; END
BINARY_OUTPUT SBO_Dec; NODE = NOD_Desk; ADDRESS = 202; ACTIVE = HIGH; END
BINARY_INPUT SBI_Zero; NODE = NOD_Desk; ADDRESS = 102; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
COUNTER_INPUT CNT_Pulses; NODE = NOD_Desk; ADDRESS = 101; ACTIVE = HIGH; PERIOD = 1; DEBOUNCE = 1; END
DC_MOTOR DCM_Width; INC = SBO_Inc; DEC = SBO_Dec; ZERO = SBI_Zero; ENCODER = CNT_Pulses; TIMEOUT = 20; BRAKING = 2; END
KEY_INPUT KEY_Go; NODE = NOD_Desk; ADDRESS = 12; ACTIVE = HIGH; MODE = TOGGLE; PERIOD = 1; END
NODE NOD_Belt; ADDRESS = 7; TYPE = ST1; END
AXIS AXI_Belt; NODE = NOD_Belt; PULSES_PER_UNIT = 11930464.711111111; TRAVEL_SPEED = 36000; ACCELERATION = 3600000;
  DECELERATION = 3600000; INITIAL_POSITION = 0; POSITION_RANGE = -1000000 1000000; END
"""
)
pytestmark = pytest.mark.long
INC, DEC, ZERO, COUNTER, MOTOR, KEY = range(1, 7)
DELAYS = st.integers(0, 4)
"""Cycles that a frame waits in a FIFO, beyond the one that it takes."""


class Delayed:
    """The frames on their way: none overtakes another, and each waits for a number of cycles."""

    def __init__(self) -> None:
        self._on_way: deque[tuple[int, Any]] = deque()

    def put(self, due: int, frame: Any) -> None:
        last = self._on_way[-1][0] if self._on_way else 0
        self._on_way.append((max(due, last), frame))

    def take(self, cycle: int) -> list[Any]:
        found = []
        while self._on_way and self._on_way[0][0] <= cycle:
            found.append(self._on_way.popleft()[1])
        return found


class Machine:
    """A PAM's objects and a real node, with a ring between them that delays orders and reports at will."""

    def __init__(
        self,
        address: int,
        order: Callable[[Order], None],
        go_on: Callable[[], None],
        reports: Callable[[], list[Report]],
        **options: Any,
    ) -> None:
        self.bench, self._address = Bench(APPLICATION, readings=ObjectReadings(**options)), address
        self._order, self._go_on, self._reports = order, go_on, reports
        self._orders, self._answers = Delayed(), Delayed()
        self.cycle, self._sent, self.delay = 0, 0, 0

    def step(self) -> None:
        """Go on for a cycle: orders that are due reach the node, and reports the PAM."""
        self.cycle += 1
        sent = self.bench.sent(self._address)
        for order in sent[self._sent :]:
            self._orders.put(self.cycle + self.delay, order)
        self._sent = len(sent)
        for order in self._orders.take(self.cycle):
            self._order(order)
        self._go_on()
        for report in self._reports():
            self._answers.put(self.cycle + 1 + self.delay, report)
        for report in self._answers.take(self.cycle):
            self.bench.report(self._address, report)
        self.bench.cycle()


class MotorNode:
    """A Smart-IO with a motor that gives a pulse every 2 ms while it is driven, and for 4 ms or 40 ms after that."""

    def __init__(self) -> None:
        self.io = SmartIoBench(motor_rest_ms=10)
        self.io.configure(
            OutputItem(INC, 201, 1, True), OutputItem(DEC, 202, 1, True), InputItem(ZERO, 102, 1, True, 1, 1),
            CounterItem(COUNTER, 101, True, 1, 1), MotorItem(MOTOR, INC, DEC, ZERO, COUNTER, 20, 2),
            KeyItem(KEY, 12, False, KeyMode.TOGGLE, 1),
        )  # fmt: skip
        self.machine = Machine(41, self._take, self._go_on, self.io.port.take)
        self._level, self._coast = False, 0
        self.is_jammed = self.is_sliding = False
        self.taken = 0
        self.states: set[tuple[bool, int]] = set()
        """The states of the motor since its last order."""
        self.keys: set[bool] = set()
        """The states of the key since the last order to it."""
        self._note()

    @property
    def motor(self) -> Any:
        drive = self.io.program._items[MOTOR]
        assert isinstance(drive, MotorDrive)
        return drive.motor

    @property
    def key(self) -> Any:
        return self.io.program._items[KEY]

    def _take(self, order: Order) -> None:
        self.io.order(order)
        if isinstance(order, MotorOrder) and order.number:
            self.taken, self.states = order.number, set()
        if isinstance(order, SetOutput):
            self.keys = set()
        self._note()

    def _note(self) -> None:
        is_on = self.io.wires.sent and (self.io.last("motor.inc") or self.io.last("motor.dec"))
        assert not (is_on and self.motor.is_ready), "an order has begun that counts as ended"
        self.states.add((self.motor.is_ready, self.motor.error_word))
        self.keys.add(self.key._key.value)

    def _go_on(self) -> None:
        is_on = bool(self.io.last("motor.inc") or self.io.last("motor.dec"))
        self._coast = (40 if self.is_sliding else 4) if is_on else max(self._coast - 1, 0)
        if (is_on or self._coast) and not self.is_jammed:
            self._level = not self._level
            self.io.wire("motor.pulse", self._level)
        self.io.run(1)
        self._note()


MOTOR_ORDERS = st.sampled_from(
    [
        ("absolute_move", 10), ("absolute_move", 0), ("relative_move", -5), ("run", "INC"), ("run", "DEC"), ("stop",),
        ("position", 3), ("zero_position", "DEC", "HIGH"), ("zero_position", "INC", "LOW"), ("stroke_limits", -8, 8),
        ("disable_stroke_limits",),
    ]
)  # fmt: skip
PLANT = st.sampled_from([("jam",), ("free",), ("slide",), ("stick",), ("zero",), ("no zero",), ("stray",)])


@pytest.mark.manual("PAML-129")
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.one_of(MOTOR_ORDERS, MOTOR_ORDERS, PLANT), st.integers(0, 60), DELAYS), max_size=12))
def test_a_motor_is_never_ready_before_its_order_has_ended(steps: list[tuple[tuple[Any, ...], int, int]]) -> None:
    node = MotorNode()
    machine, bench = node.machine, node.machine.bench
    ordered = 0
    for (what, *arguments), cycles, machine.delay in steps:
        match what:
            case "jam" | "free":
                node.is_jammed = what == "jam"
            case "slide" | "stick":
                node.is_sliding = what == "slide"
            case "zero" | "no zero":
                node.io.wire("motor.zero", what == "zero")
            case "stray":
                node.io.pulse(3, every_ms=2)
            case _:
                ends = what not in ("position", "stroke_limits", "disable_stroke_limits")
                bench.do("DCM_Width", what, *arguments)
                ordered += ends
                assert not ends or not bench.ask("DCM_Width", "ready")
        for _ in range(cycles):
            machine.step()
            if bench.ask("DCM_Width", "ready"):
                assert node.taken == ordered, "the node does not even know the order"
                assert (True, bench.ask("DCM_Width", "error_code")) in node.states
    machine.delay = 0
    bench.do("DCM_Width", "stop")
    for _ in range(300):
        machine.step()
    assert bench.ask("DCM_Width", "ready")
    assert bench.ask("DCM_Width", "error_code") == node.motor.error_word


@pytest.mark.manual("PAML-092")
@settings(max_examples=100, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from(["set", "reset", "invert", "press", "release"]), st.integers(0, 4), DELAYS),
        max_size=15,
    )
)
def test_a_key_never_shows_what_it_was_before_it_was_written(steps: list[tuple[str, int, int]]) -> None:
    node = MotorNode()
    machine, key = node.machine, node.machine.bench.item("KEY_Go")
    written = {False}
    for what, cycles, machine.delay in steps:
        if what in ("press", "release"):
            node.io.wire("start", what == "press")
        else:
            key.do(what)
            written, node.keys = {key.value()}, set()
        for _ in range(cycles):
            machine.step()
            assert key.value() in node.keys | written
    machine.delay = 0
    for _ in range(30):
        machine.step()
    assert key.value() is node.key._key.value


class AxisNode:
    """An ST1 whose clock goes on by a millisecond with each cycle."""

    def __init__(self, *, run_lasts: bool) -> None:
        """A run ends when nothing runs any more if `run_lasts` is true, and otherwise at its speed."""
        self._run_lasts, self._is_run = run_lasts, False
        self.st1 = ProgramBench(power=False)
        assert self.st1.program.accept(AxisItem(AXIS, 0, 0))
        self.st1.program.run()
        self.machine = Machine(7, self._take, self._go_on, self._reports, run_is_ready_at_speed=not run_lasts)
        self.taken, self.has_ended = 0, True

    def _go_on(self) -> None:
        self.st1.cycle()

    def _take(self, order: Order) -> None:
        self.st1.send(order)
        if isinstance(order, AxisOrder) and order.number:
            self.taken, self.has_ended = order.number, False
            if order.move is not Move.POSITION:
                self._is_run = order.move is Move.RUN and order.value != 0
        self._note()

    def _note(self) -> None:
        servo = self.st1.servo
        runs = self._run_lasts and self._is_run and servo.set.doing is Doing.RUN
        self.has_ended = self.has_ended or not (servo.answers.waits or runs)

    def _reports(self) -> list[Report]:
        self._note()
        sent, self.st1.port.sent = self.st1.port.sent, []
        return sent


AXIS_ORDERS = st.sampled_from(
    [
        ("power_on",), ("power_off",), ("absolute_move", 300), ("absolute_move", -20), ("relative_move", 40),
        ("run", 3600), ("run", 0), ("stop",), ("position", 0), ("position", 77), ("update_status",),
    ]
)  # fmt: skip
NAMES = ("position", "update_status")


@pytest.mark.manual("PAML-059")
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(AXIS_ORDERS, st.integers(0, 15), DELAYS), max_size=12), st.booleans())
def test_an_axis_is_never_ready_before_its_order_has_ended(
    steps: list[tuple[tuple[Any, ...], int, int]], run_lasts: bool
) -> None:
    node = AxisNode(run_lasts=run_lasts)
    machine, bench = node.machine, node.machine.bench
    bench.do("AXI_Belt", "power_on")
    for (what, *arguments), cycles, machine.delay in steps:
        was_ready = bench.ask("AXI_Belt", "ready")
        bench.do("AXI_Belt", what, *arguments)
        assert bench.ask("AXI_Belt", "ready") is (was_ready and what in NAMES), "PAML-059"
        for _ in range(cycles):
            machine.step()
            if bench.ask("AXI_Belt", "ready"):
                assert node.taken == bench.item("AXI_Belt").ordered
                assert node.has_ended
    machine.delay = 0
    bench.do("AXI_Belt", "stop")
    for _ in range(300):
        machine.step()
    assert bench.ask("AXI_Belt", "ready")


@pytest.mark.manual("PAML-062")
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(AXIS_ORDERS, st.integers(0, 15), DELAYS), max_size=12), st.booleans())
def test_the_position_of_an_axis_at_rest_is_that_of_its_node(
    steps: list[tuple[tuple[Any, ...], int, int]], run_lasts: bool
) -> None:
    node = AxisNode(run_lasts=run_lasts)
    machine, bench = node.machine, node.machine.bench
    bench.do("AXI_Belt", "power_on")
    for _ in range(10):
        machine.step()
    for (what, *arguments), cycles, machine.delay in steps:
        if what == "power_off":
            continue
        bench.do("AXI_Belt", what, *arguments)
        for _ in range(cycles):
            machine.step()
    machine.delay = 0
    for _ in range(300):
        machine.step()
    servo = node.st1.servo
    if not servo.set.is_moving and bench.ask("AXI_Belt", "ready"):
        own = servo.set.own_at(node.st1.clock.now_ns()) / 11930464.711111111
        assert bench.ask("AXI_Belt", "position") == pytest.approx(own, abs=1e-6)
