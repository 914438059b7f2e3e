"""Axes on CAN answer the same, to the last bit, in whole cycles and in those that do no more than they need."""

import pytest
from can_face_bench import NODE, CanFaceBench
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.testing import plain_forms
from fieldrig_devices.cia402.pace import PACE
from fieldrig_devices.max4.can.motor import AxisMotor

SHOWN = (0x6041, 0x6061, 0x6064, 0x606C, 0x6077, 0x60F4, 0x60FC)
SIZES = {1: 0x2F, 2: 0x2B, 4: 0x23}
"""The command byte of an expedited download by the number of its bytes (CiA 301 7.2.4.3.3)."""
RUNNING = [
    ((0x6060, 1, 3), 4), ((0x6040, 2, 0x06), 100), ((0x6040, 2, 0x07), 100), ((0x6040, 2, 0x0F), 400),
    ((0x60FF, 4, 1_000_000), 200),
]  # fmt: skip
"""The writes that bring an axis to a steady velocity, each with the milliseconds after it."""
velocities = st.sampled_from([0, 1000, 100_000, 1_000_000, -1_000_000, 20_000_000])
writes = st.one_of(
    st.tuples(
        st.just(0x6040), st.just(2), st.sampled_from([0x00, 0x02, 0x06, 0x07, 0x0F, 0x1F, 0x3F, 0x5F, 0x10F, 0x80])
    ),
    st.tuples(st.just(0x6060), st.just(1), st.sampled_from([1, 3, 6, 8, 9])),
    st.tuples(st.just(0x60FF), st.just(4), velocities),
    st.tuples(st.just(0x607A), st.just(4), st.sampled_from([0, 1, 50_000, 1_000_000, -250_000])),
    st.tuples(st.just(0x6081), st.just(4), velocities.map(abs)),
    st.tuples(st.just(0x6083), st.just(4), st.sampled_from([1000, 1_000_000, 10_000_000])),
    st.tuples(st.just(0x60B8), st.just(2), st.sampled_from([0, 0x15, 0x13])),
    st.tuples(st.just(0x6065), st.just(4), st.sampled_from([0, 3, 100_000, 0xFFFF_FFFF])),
)
scripts = st.lists(st.tuples(writes, st.sampled_from([1, 4, 17, 80])), min_size=1, max_size=12)
Write = tuple[int, int, int]


def put(bench: CanFaceBench, index: int, size: int, value: int) -> None:
    data = (value & (1 << 8 * size) - 1).to_bytes(4, "little")
    bench.send(f"{0x600 + NODE:03X}#{SIZES[size]:02X} {index.to_bytes(2, 'little').hex(' ')} 00 {data.hex(' ')}")


def trace(script: list[tuple[Write, int]]) -> list[str]:
    """Return all frames of a run, in which the objects are read after each write."""
    bench = CanFaceBench("real", simulated=("ideal",)).boot()
    bench.send(f"000#01 {NODE:02x}")
    frames = []
    for (index, size, value), ms in [*RUNNING, *script]:
        for offset in (0, 0x800):
            put(bench, index + offset, size, value)
        bench.run(ms)
        frames += bench.take()
        for shown in SHOWN:
            for offset in (0, 0x800):
                place = (shown + offset).to_bytes(2, "little").hex(" ")
                frames += bench.send(f"{0x600 + NODE:03X}#40 {place} 00 00 00 00 00")
    return frames


@pytest.mark.long
@settings(max_examples=8, deadline=None)
@given(scripts)
def test_axes_that_do_no_more_than_they_need_answer_the_same(script: list[tuple[Write, int]]) -> None:
    with plain_forms(PACE.name):
        plain = trace(script)
    assert trace(script) == plain


def test_a_motor_has_news_until_a_cycle_has_taken_it_over() -> None:
    """An axis at rest would do whole cycles otherwise, which nothing outside shows but the time that they take."""
    motor = AxisMotor(lambda: None)
    seen = [motor.is_changed]
    motor.refresh()
    seen.append(motor.is_changed)
    motor.bind(None, {}, {})
    seen.append(motor.is_changed)
    assert seen == [True, False, True]
