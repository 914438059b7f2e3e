"""Whatever arrives from the ring, a node goes on, and its reports fit into frames."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from st1_bench import ProgramBench

from fieldrig_devices.pamring import codec
from fieldrig_devices.pamring.ends import RingFault
from fieldrig_devices.pamring.frames import (
    AxisItem,
    AxisOrder,
    EndOfPipe,
    InputItem,
    Move,
    OutputItem,
    Read,
    SetOutput,
    SetPoint,
    SetPointMode,
)

words = st.one_of(st.integers(-(1 << 63), (1 << 63) - 1), st.integers(-3, 3), st.integers(-(1 << 36), 1 << 36))
counts = st.integers(0, (1 << 32) - 1)
items = st.integers(0, 3)
orders = st.one_of(
    st.builds(AxisOrder, counts, st.sampled_from(Move), words, words, words, words),
    st.builds(SetPoint, st.sampled_from(SetPointMode), words),
    st.builds(EndOfPipe, st.sampled_from(SetPointMode)),
    st.builds(Read, counts, st.integers(0, 0xFFFF)),
    st.builds(SetOutput, items, words),
)
configurations = st.one_of(
    st.builds(AxisItem, items, words, words),
    st.builds(InputItem, items, st.integers(99, 217), items, st.booleans(), counts, counts),
    st.builds(OutputItem, items, st.integers(199, 210), items, st.booleans()),
)
events = st.lists(
    st.tuples(st.one_of(orders, configurations, st.sampled_from(RingFault)), st.integers(0, 5)), max_size=12
)


@pytest.mark.long
@settings(deadline=None, max_examples=60)
@given(events, st.booleans())
def test_a_node_takes_any_order(given_events: list[tuple[object, int]], has_board: bool) -> None:
    bench = ProgramBench(oio_board=has_board)
    program = bench.program
    for event, cycles in given_events:
        if isinstance(event, RingFault):
            program.ring(event)
        elif isinstance(event, AxisItem | InputItem | OutputItem):
            program.accept(event)
            program.run()
        else:
            assert isinstance(event, AxisOrder | SetPoint | EndOfPipe | Read | SetOutput)
            program.order(event)
        bench.cycle(cycles)
    bench.wait(50)
    for report in bench.port.sent:
        codec.encode(report)
