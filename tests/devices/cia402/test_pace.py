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
            seen = motor.is_there, motor.is_ready, motor.is_following, motor.is_stopping, motor.error, motor.has_warning
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


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(events, st.integers(0, 60)), max_size=12))
@pytest.mark.long
def test_the_fast_form_shows_what_the_whole_cycle_shows(script: list[tuple[Event, int]]) -> None:
    whole, paced = running(Cia402Bench()), running(PacedBench())
    for event, cycles in [(lag(0), 40), *script, (lag(0), 20)]:
        event(whole)
        event(paced)
        assert shown(whole) == shown(paced)
        for _ in range(cycles):
            assert shown(whole.cycles(1)) == shown(paced.cycles(1))


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
