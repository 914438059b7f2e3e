"""The fast form of a CiA 402 axis shows, cycle by cycle, what the whole cycle shows."""

from collections.abc import Callable
from typing import Final

import pytest
from cia402_bench import Cia402Bench
from hypothesis import given, settings
from hypothesis import strategies as st

PROFILE_VELOCITY: Final = 3
STATUS, POSITION, FOLLOWING_ERROR = 0x6041, 0x6064, 0x60F4
SHOWN: Final = (STATUS, 0x6061, 0x6062, POSITION, 0x606B, 0x606C, FOLLOWING_ERROR, 0x60B9, 0x60BA, 0x60FC, 0x60FD)


class PacedBench(Cia402Bench):
    """Its cycles are those of `max4.can_face.FaceNode`: no more than the axis needs."""

    def __init__(self) -> None:
        self._seen: tuple[object, ...] = ()
        self.short = 0
        """Cycles in which nothing but the motion went on."""
        super().__init__()
        axis, whole = self.axis, self.axis.step
        drive_step = axis.drive.step
        self._drive_steps = 0

        def count() -> None:
            self._drive_steps += 1
            drive_step()

        def paced() -> None:
            motor = self.motor
            seen = (
                motor.is_there,
                motor.is_ready,
                motor.is_following,
                motor.is_stopping,
                motor.errors,
                motor.has_warning,
            )
            is_changed, self._seen = seen != self._seen, seen
            if is_changed or axis.is_awake:
                whole()
            elif axis.drive.is_moving:
                before = self._drive_steps
                axis.drive.advance()
                self.short += self._drive_steps == before

        axis.drive.step = count  # type: ignore[method-assign]
        axis.step = paced  # type: ignore[method-assign]


def shown(bench: Cia402Bench) -> list[str]:
    values = [bench.node.dictionary.find(index, 0).present for index in SHOWN]
    return [*map(str, values), str(bench.motor.position), *bench.take()]


def running(bench: Cia402Bench) -> Cia402Bench:
    return bench.put(0x60FF, 1_000_000).enabled(PROFILE_VELOCITY)


Event = Callable[[Cia402Bench], object]

indices = st.sampled_from([0x6065, 0x6066, 0x606D, 0x606E, 0x606F, 0x6070, 0x607F, 0x6083, 0x6084, 0x605D, 0x6007])


def write(index: int, value: int, subindex: int = 0) -> Event:
    return lambda bench: bench.try_put(index, value, subindex)


def lag(increments: int) -> Event:
    return lambda bench: setattr(bench.motor, "lag", increments)


def switches(inputs: int) -> Event:
    return lambda bench: setattr(bench.motor, "switches", lambda position: inputs)


def fail(error: int) -> Event:
    return lambda bench: setattr(bench.motor, "error", error)


events: st.SearchStrategy[Event] = st.one_of(
    st.builds(write, st.just(0x60FF), st.sampled_from([0, 900_000, 1_000_000, -1_000_000, 20_000_000])),
    st.builds(write, st.just(0x6040), st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x10F, 0x80])),
    st.builds(write, st.just(0x6060), st.sampled_from([1, 3, 4, 8, 9])),
    st.builds(write, st.just(0x60B8), st.sampled_from([0, 0x15, 0x13, 0x1111])),
    st.builds(write, indices, st.sampled_from([0, 1, 3, 100, 10_000, 60_000])),
    st.builds(write, st.just(0x607D), st.sampled_from([-2_000_000, 500_000, 2_000_000]), st.sampled_from([1, 2])),
    st.builds(write, st.just(0x607E), st.sampled_from([0, 0x40, 0x80, 0xC0])),
    st.builds(write, st.just(0x6091), st.sampled_from([1, 2, 10]), st.sampled_from([1, 2])),
    st.builds(lag, st.sampled_from([0, 10, 5_000, 100_000])),
    st.builds(switches, st.sampled_from([0, 0x1, 0x2, 0x3, 0x1_0000])),
    st.builds(fail, st.sampled_from([0, 0x4310])),
    st.just(lambda bench: bench.send("000#80 05")),
    st.just(lambda bench: bench.send("000#01 05")),
    st.just(lambda bench: bench.send("000#82 05")),
)


def warn(is_on: bool) -> Event:
    return lambda bench: setattr(bench.motor, "has_warning", is_on)


def send(frame: str) -> Event:
    return lambda bench: bench.send(frame)


def assert_alike(script: list[tuple[Event, int]]) -> None:
    """Check that both forms show the same in each cycle of a script of events and cycles."""
    whole, paced = running(Cia402Bench()), running(PacedBench())
    for event, cycles in script:
        event(whole)
        event(paced)
        assert shown(whole) == shown(paced)
        for _ in range(cycles):
            assert shown(whole.cycles(1)) == shown(paced.cycles(1))


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(events, st.integers(0, 60)), max_size=12))
@pytest.mark.long
def test_the_fast_form_shows_what_the_whole_cycle_shows(script: list[tuple[Event, int]]) -> None:
    assert_alike([(lag(0), 40), *script, (lag(0), 20)])


STEADY: Final = (lag(0), 80)
"""At its speed: 1,000,000 in 1 s are reached, and so is the time of both windows."""
OFF: Final = (write(0x6040, 0x06), 60)
WIDE: Final = [(write(0x606D, 60_000), 0), (write(0x606F, 10), 0)]
"""A velocity window that is wider than the threshold."""
SCRIPTS: Final[dict[str, list[tuple[Event, int]]]] = {
    "a reset of a node that is off": [OFF, (send("000#81 05"), 5), (write(0x6040, 0x06), 5)],
    "a command during a reset": [OFF, (send("000#81 05"), 0), (write(0x6040, 0x06), 5)],
    "a reset of a node that runs": [STEADY, (send("000#81 05"), 5), (send("000#01 05"), 5)],
    "a stopped node, a fault": [STEADY, (write(0x6007, 1), 3), (send("000#02 05"), 30)],
    "a stopped node, no voltage": [STEADY, (write(0x6007, 2), 3), (send("000#02 05"), 30)],
    "a stopped node, a quick stop": [STEADY, (write(0x6007, 3), 3), (send("000#02 05"), 60)],
    "a quick stop": [STEADY, (write(0x6040, 0x02), 60), (write(0x6040, 0x0F), 20)],
    "a quick stop that is taken back at once": [
        *WIDE, (write(0x606E, 20), 0), (write(0x6070, 20), 0), (write(0x6085, 1_000_000), 0), (write(0x605A, 6), 0),
        STEADY, (write(0x6040, 0x02), 1), (write(0x6040, 0x0F), 80)
    ],
    "a shutdown and on again": [STEADY, OFF, (write(0x6040, 0x07), 5), (write(0x6040, 0x0F), 60)],
    "a halt and on again": [STEADY, (write(0x6040, 0x10F), 60), (write(0x6040, 0x0F), 80)],
    "a halt within a wide window": [*WIDE, STEADY, (write(0x6040, 0x10F), 3), (write(0x60FF, 3_000), 80)],
    "a fault and its reset": [STEADY, (fail(0x4310), 20), (write(0x6040, 0x80), 20)],
    "a fault of an axis that is off": [OFF, (fail(0x4310), 10), (fail(0), 3), (write(0x6040, 0x80), 5)],
    "a warning": [STEADY, (warn(True), 5), (warn(False), 5)],
    "an armed probe": [STEADY, (write(0x60B8, 0x13), 10), (switches(0x1_0000), 3), (switches(0), 10), (lag(0), 20)],
    "a probe at the zero of each turn": [STEADY, (write(0x60B8, 0x17), 300)],
    "a switch ahead": [STEADY, (switches(0x2), 40), (switches(0), 60)],
    "a switch behind": [STEADY, (switches(0x1), 40), (switches(0), 60)],
    "a switch that the axis overruns": [
        *WIDE, (write(0x6085, 1_000_000), 0), STEADY, (switches(0x2), 2), (switches(0), 300)
    ],
    "a lag": [STEADY, (lag(3_000), 30), (lag(0), 30)],
    "a velocity beyond the window": [STEADY, (lag(60), 6), (lag(0), 6)],
    "a velocity backwards below the threshold": [
        (write(0x606D, 60_000), 0), (write(0x60FF, -20_000), 100), (lag(-60), 6), (lag(0), 6)
    ],
    "a lag within a wide window": [*WIDE, STEADY, (lag(100), 10), (lag(50), 10)],
    "a lag that is a following error": [(write(0x6065, 1_000), 0), STEADY, (write(0x6066, 20), 5), (lag(9_000), 40)],
    "a following error in a whole cycle": [
        (write(0x6065, 1_000), 0), (write(0x6066, 0), 0), STEADY, (lag(9_000), 1), (warn(True), 10)
    ],
    "a window for the following error": [STEADY, (lag(500), 4), (write(0x6065, 100), 60)],
    "a new target": [STEADY, (write(0x60FF, 400_000), 80), (write(0x60FF, -400_000), 200)],
    "a target within the window": [*WIDE, STEADY, (write(0x60FF, 1_010_000), 40)],
    "a target below the threshold": [(write(0x606F, 5_000), 0), STEADY, (write(0x60FF, 1_000), 300)],
    "a threshold that takes its time": [(write(0x6070, 200), 0), STEADY],
    "a window that takes its time": [(write(0x606E, 200), 0), STEADY],
    "no target": [STEADY, (write(0x60FF, 0), 300)],
    "another mode": [STEADY, (write(0x6060, 9), 30), (write(0x6060, 3), 60)],
    "a mode of torque": [STEADY, (write(0x6060, 4), 30), (write(0x6060, 3), 60)],
    "a mode of position": [STEADY, (write(0x6060, 1), 30), (write(0x6060, 3), 60)],
    "another window": [STEADY, (write(0x606D, 1), 5), (lag(50), 20), (lag(0), 20)],
    "another threshold": [STEADY, (write(0x606F, 65_535), 40), (write(0x606F, 1), 40)],
    "another gear": [STEADY, (write(0x6091, 2, 1), 60)],
    "a software limit ahead": [STEADY, (write(0x607D, -2_000_000, 1), 0), (write(0x607D, 900_000, 2), 300)],
    "a software limit from the start": [
        (write(0x607D, -2_000_000, 1), 0), (write(0x607D, 900_000, 2), 0), STEADY, (lag(0), 200)
    ],
    "a lower maximum": [STEADY, (write(0x607F, 500_000), 20), (write(0x60FF, 900_000), 80)],
}  # fmt: skip


@pytest.mark.parametrize("what", SCRIPTS)
@pytest.mark.long
def test_the_fast_form_shows_the_same_at_each_event(what: str) -> None:
    assert_alike([*SCRIPTS[what], (lag(0), 20)])


@pytest.mark.long
def test_an_axis_at_its_speed_takes_the_short_cycle() -> None:
    bench = PacedBench()
    running(bench).cycles(300)
    before = bench.short
    assert bench.cycles(50).status(0x400) == 0x400
    assert bench.short == before + 50


@pytest.mark.long
def test_a_new_target_a_lag_and_a_switch_end_the_short_cycle() -> None:
    for event in (write(0x60FF, 500_000), write(0x606D, 1), lag(100_000), switches(0x2), write(0x6040, 0x10F)):
        bench = PacedBench()
        running(bench).cycles(300)
        before = bench.short
        event(bench)
        bench.cycles(2)  # a lag is seen in the cycle after it
        assert bench.short < before + 2
