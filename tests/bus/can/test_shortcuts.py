"""A calm bus that is not played step by step delivers the same, at the same instants, as one that is."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import US
from fieldrig.testing import plain_forms
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.model import CALM, CanBusModel

MEMBERS = ("a", "b", "c")
frames = st.one_of(
    st.builds(CanFrame, st.integers(0, 7), st.binary(max_size=8)),
    st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8), is_extended=st.booleans()),
    st.builds(CanFrame, st.integers(0, 3), is_remote=st.just(True), remote_length=st.integers(0, 8)),
    st.builds(CanFrame, st.integers(0, 7), st.binary(min_size=12, max_size=12), is_fd=st.just(True)),
)
asked = st.lists(
    st.tuples(st.sampled_from([0, 1, 10, 100, 111, 222, 1000]), st.sampled_from(MEMBERS), frames), max_size=40
)


def trace(asked_frames: list[tuple[int, str, CanFrame]], interest: list[list[int]] | None) -> list[str]:
    """Return the deliveries and the counters of a bus; each frame is asked for some microseconds after the last."""
    model = CanBusModel(500_000, 2_000_000)
    for member in MEMBERS:
        model.join(member)
        model.listen(0, member, interest)
    now_ns = 0
    shown: list[str] = []
    for after_us, member, frame in asked_frames:
        now_ns += after_us * US
        while (next_ns := model.next_ns()) is not None and next_ns <= now_ns:
            shown += map(repr, model.collect(next_ns))
        model.submit(now_ns, member, frame)
    while (next_ns := model.next_ns()) is not None:
        shown += map(repr, model.collect(next_ns))
        shown.append(repr((next_ns, model.statistics(next_ns))))
    return shown


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(asked, st.sampled_from([None, [[0, 4]], []]))
def test_a_calm_bus_delivers_the_same_in_both_forms(
    asked_frames: list[tuple[int, str, CanFrame]], interest: list[list[int]] | None
) -> None:
    with plain_forms(CALM.name):
        plain = trace(asked_frames, interest)
    assert trace(asked_frames, interest) == plain
