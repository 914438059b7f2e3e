"""The multi-comparator: references in a flow, times that are learned, and their reproduction."""

from itertools import pairwise
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.pam.pipes.multi_comparator import Mode, MultiComparator, Reference, Slope, Trace

MS = 0.001
PERIOD = 1.0
STEP = 0.004
"""The way of the flow in a period of a millisecond; a cycle of the machine takes 250 of them."""


def approximately(place: float) -> Any:
    return pytest.approx(place, abs=0.01)


class Machine:
    """A flow with a period of 1.0, and the places at which routines started."""

    def __init__(self, traces: int = 1, origin: Reference | None = None, period: float | None = PERIOD) -> None:
        self.fired: list[tuple[str, float]] = []
        self.place = 0.001
        self.speed = STEP
        self.period = period
        self.block = MultiComparator(origin or Reference("POSITIVE", "IMMEDIATE", 0.05), period)
        self.block.origin_routine = lambda: self.fired.append(("origin", round(self.place, 6)))
        self.traces = [Trace() for _ in range(traces)]
        for number, trace in enumerate(self.traces):
            trace.routine = lambda number=number: self.fired.append((str(number), round(self.place, 6)))  # type: ignore[misc]
        self.block.traces = self.traces
        self.block.start(MS)

    def flow(self, periods: int) -> list[tuple[str, float]]:
        """Go on, and return what was fired."""
        self.fired = []
        for _ in range(periods):
            assert self.block.pass_on(self.place) == self.place
            self.place += self.speed
            if self.period is not None:
                self.place %= self.period
        return self.fired

    def install(self, trace: int, position: float, slope: Slope = "POSITIVE", mode: Mode = "IMMEDIATE") -> None:
        self.traces[trace].install(Reference(slope, mode, position), 0.0, self.period)


@pytest.mark.manual("PAML-552")
@pytest.mark.manual("PAML-557")
def test_learning_fires_at_the_references_behind_the_origin() -> None:
    machine = Machine(2)
    assert machine.flow(300) == []
    machine.place = 0.001
    machine.block.learn()
    assert not machine.block.is_executing
    machine.install(0, 0.2)
    machine.install(1, 0.1)
    assert machine.flow(60) == [("origin", 0.053), ("1", 0.101), ("0", 0.201)]
    assert machine.flow(250) == []  # each of them once
    assert machine.block.state == "deactivated"  # PAML-560


@pytest.mark.manual("PAML-554")
@pytest.mark.manual("PAML-560")
def test_a_routine_installs_the_next_reference_of_its_trace() -> None:
    machine = Machine()
    places = [0.2, 0.4, 0.3]
    machine.traces[0].routine = lambda: machine.install(0, places.pop(0)) if places else None
    machine.block.learn()
    machine.install(0, 0.1)
    machine.flow(150)
    assert len(places) == 0
    states: list[str] = [machine.block.state]
    machine.flow(180)  # 0.3 comes in the next period
    assert [*states, machine.block.state] == ["tracing", "deactivated"]


@pytest.mark.manual("PAML-551")
@pytest.mark.manual("PAML-558")
def test_execution_fires_at_the_learned_times_less_the_delay() -> None:
    machine = Machine()
    machine.block.learn()
    machine.install(0, 0.2)
    assert machine.flow(249) == [("origin", 0.053), ("0", 0.201)]  # 37 periods behind the origin
    machine.place, machine.speed = 0.001, STEP / 2  # time counts from now on, not the flow
    machine.block.execute()
    assert machine.block.is_executing
    machine.traces[0].install(Reference("POSITIVE", "IMMEDIATE", 0.2), 0.010, PERIOD)
    origin, fired = machine.flow(300)
    assert origin == ("origin", 0.051)
    assert fired[1] == pytest.approx(0.051 + 27 * STEP / 2)


@pytest.mark.manual("PAML-559")
def test_a_changed_reference_is_learned_alone() -> None:
    machine = Machine(2)
    machine.block.learn()
    machine.install(0, 0.2)
    machine.install(1, 0.3)
    machine.flow(249)
    machine.place, machine.speed = 0.001, STEP / 2
    machine.block.execute()
    machine.install(0, 0.2)
    machine.install(1, 0.5)
    assert [name for name, _ in machine.flow(400)] == ["origin", "0", "1"]
    assert machine.fired[2][1] == pytest.approx(0.501, abs=0.002)  # on the flow
    machine.place = 0.001
    machine.block.execute()
    machine.install(1, 0.5)
    machine.install(0, 0.2)
    machine.speed = STEP
    name, place = machine.flow(600)[2]
    assert (name, place) == ("1", approximately(0.05 + 225 * STEP))  # at its time


@pytest.mark.manual("PAML-556")
def test_the_next_period_begins_with_the_flow() -> None:
    machine = Machine(2, Reference("POSITIVE", "NEXT_PERIOD", 0.05))
    machine.block.learn()
    machine.install(0, 0.2)
    machine.install(1, 0.2, mode="NEXT_PERIOD")
    assert machine.flow(250) == []
    assert [name for name, _ in machine.flow(250)] == ["origin", "0"]
    assert [name for name, _ in machine.flow(250)] == ["1"]
    linear = Machine(1, Reference("POSITIVE", "NEXT_PERIOD", 0.05), None)
    linear.block.learn()
    assert [name for name, _ in linear.flow(100)] == ["origin"]  # G-34


@pytest.mark.manual("PAML-555")
@pytest.mark.parametrize(
    ("slope", "place"), [("POSITIVE", 3), ("NEGATIVE", 7), ("ZERO_MAXIMUM", 6), ("ZERO_MINIMUM", 11)]
)
def test_slopes(slope: Slope, place: int) -> None:
    block = MultiComparator(Reference(slope, "IMMEDIATE", 2.5), None)
    fired: list[int] = []
    block.start(MS)
    block.learn()
    for number, value in enumerate([0, 1, 2, 3, 4, 5, 4, 2, 1, 0, -1, 0, 1]):
        block.origin_routine = lambda here=number: fired.append(here)  # type: ignore[misc]
        block.pass_on(value)
    assert fired == [place]


@pytest.mark.manual("PAML-553")
def test_a_trace_has_eight_references_in_a_cycle() -> None:
    machine = Machine()
    machine.block.learn()
    fired: list[float] = []

    def fire() -> None:
        fired.append(machine.place)
        machine.install(0, 0.1 + len(fired) / 20)

    machine.traces[0].routine = fire
    machine.install(0, 0.1)
    machine.flow(400)
    assert fired == pytest.approx([0.1 + number / 20 for number in range(8)], abs=STEP)


@pytest.mark.manual("PAML-562")
def test_learning_may_be_ordered_before_the_pipe_begins_and_is_forgotten_at_its_end() -> None:
    machine = Machine()
    machine.block.stop()
    machine.block.learn()
    machine.block.start(MS)
    machine.install(0, 0.2)
    assert [name for name, _ in machine.flow(60)] == ["origin", "0"]
    machine.block.stop()
    assert machine.block.state == "deactivated"
    machine.block.execute()
    machine.block.start(MS)
    machine.place, machine.speed = 0.001, STEP / 2
    machine.install(0, 0.2)
    assert machine.flow(200)[1] == ("0", approximately(0.201))  # learned again, on the flow


@pytest.mark.long
@settings(max_examples=40)
@given(st.lists(st.floats(0.06, 0.95), min_size=1, max_size=8, unique=True), st.floats(0.0005, 0.02))
def test_each_installed_reference_fires_once_and_in_order(places: list[float], speed: float) -> None:
    machine = Machine(len(places))
    machine.speed = speed
    machine.block.learn()
    for trace, place in enumerate(places):
        machine.install(trace, place)
    order = [int(name) for name, _ in machine.flow(int(1.2 / speed)) if name != "origin"]
    assert sorted(order) == list(range(len(places)))
    assert all(places[a] <= places[b] + speed for a, b in pairwise(order))
