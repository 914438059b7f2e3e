"""Laws of any CAN bus, for any frames and any order of submission."""

from dataclasses import replace
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Delivery
from fieldrig.clock import US, S
from fieldrig_bus.can.arbitration import priority
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import classical_bits
from fieldrig_bus.can.model import CanBusModel

MEMBERS = ["a", "b", "c", "d"]
BITRATE = 500_000
BIT_NS = S // BITRATE
INTERMISSION_NS = 3 * BIT_NS
FOREVER = 1000 * S


class Asked(NamedTuple):
    asked_ns: int
    member: str
    frame: CanFrame


frames = st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8), is_extended=st.booleans()) | st.builds(
    CanFrame, st.integers(0, 3), is_remote=st.just(True), remote_length=st.integers(0, 8)
)


def of_its_own(asked: Asked) -> Asked:
    """Members share no identifiers: the last bits are those of the member.  (`test_error_laws` has the other case.)"""
    identifier = asked.frame.identifier & ~3 | MEMBERS.index(asked.member)
    return asked._replace(frame=replace(asked.frame, identifier=identifier))


instants = st.integers(0, 3000).map(lambda us: us * US)
asked_frames = st.lists(st.builds(Asked, instants, st.sampled_from(MEMBERS), frames).map(of_its_own))
in_time = asked_frames.map(lambda drawn: sorted(drawn, key=lambda asked: asked.asked_ns))


def model_with(asked_frames: list[Asked]) -> CanBusModel:
    model = CanBusModel(BITRATE)
    for member in MEMBERS:
        model.join(member)
        model.listen(0, member, None)
    for asked in asked_frames:
        model.submit(asked.asked_ns, asked.member, asked.frame)
    return model


def start_ns(delivery: Delivery[CanMessage]) -> int:
    return delivery.time_ns + INTERMISSION_NS - bits_of(delivery) * BIT_NS


def bits_of(delivery: Delivery[CanMessage]) -> int:
    assert isinstance(delivery.message, CanFrame)
    return classical_bits(delivery.message)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(in_time)
def test_every_frame_arrives_once_and_first_in_first_out(asked_frames: list[Asked]) -> None:
    deliveries = model_with(asked_frames).collect(FOREVER)
    for member in MEMBERS:
        assert [each.message for each in deliveries if each.sender == member] == [
            asked.frame for asked in asked_frames if asked.member == member
        ]


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(in_time)
def test_frames_never_overlap_and_the_winner_is_the_lowest_that_waits(asked_frames: list[Asked]) -> None:
    waiting = {member: [asked for asked in asked_frames if asked.member == member] for member in MEMBERS}
    free_ns = 0
    for delivery in model_with(asked_frames).collect(FOREVER):
        heads = [queue[0] for queue in waiting.values() if queue]
        start = start_ns(delivery)
        assert start == max(free_ns, min(asked.asked_ns for asked in heads))
        rivals = [asked for asked in heads if asked.asked_ns <= start]
        winner = min(rivals, key=lambda asked: (priority(asked.frame), MEMBERS.index(asked.member)))
        assert (winner.member, winner.frame) == (delivery.sender, delivery.message)
        waiting[winner.member].pop(0)
        free_ns = delivery.time_ns + INTERMISSION_NS


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(asked_frames, st.integers(0, 4000))
def test_the_bus_carries_no_more_bits_than_fit(asked_frames: list[Asked], until_us: int) -> None:
    model = model_with(asked_frames)
    deliveries = model.collect(until_us * US)
    busy_bits = sum(bits_of(each) - 3 for each in deliveries)
    assert busy_bits * BIT_NS <= until_us * US
    assert all(each.time_ns <= until_us * US for each in deliveries)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(in_time)
def test_it_does_not_matter_in_how_many_steps_it_is_collected(asked_frames: list[Asked]) -> None:
    stepped: list[Delivery[CanMessage]] = []
    model = model_with(asked_frames)
    while (next_ns := model.next_ns()) is not None:
        step = model.collect(next_ns)
        assert [each.time_ns for each in step] == [next_ns]
        stepped += step
    assert stepped == model_with(asked_frames).collect(FOREVER)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(in_time)
def test_the_order_in_which_members_tell_does_not_matter(asked_frames: list[Asked]) -> None:
    """Submitted late, but before collecting: only the order within one member matters."""
    by_member = sorted(asked_frames, key=lambda asked: MEMBERS.index(asked.member))
    assert model_with(by_member).collect(FOREVER) == model_with(asked_frames).collect(FOREVER)


@pytest.mark.long
@settings(max_examples=200, deadline=None)
@given(asked_frames)
def test_time_never_runs_back_even_with_late_submissions(asked_frames: list[Asked]) -> None:
    model = model_with([])
    ends = [0]
    for asked in asked_frames:  # in any order of time, with collecting in between
        model.submit(asked.asked_ns, asked.member, asked.frame)
        for delivery in model.collect(1500 * US):
            assert start_ns(delivery) >= ends[-1] + (INTERMISSION_NS if ends[-1] else 0)
            ends.append(delivery.time_ns)
    model.collect(FOREVER)
    assert model.statistics(FOREVER)["frames"] == len(asked_frames)


@pytest.mark.parametrize("bitrate", [None, 1_000_000, 83_333])
def test_the_same_calls_give_the_same_deliveries(bitrate: int | None) -> None:
    def run() -> list[Delivery[CanMessage]]:
        model = CanBusModel(bitrate)
        for member in MEMBERS:
            model.join(member)
            model.listen(0, member, [[ord(member), 0x7]])
        for number in range(200):
            frame = CanFrame(number * 37 % 0x800, bytes([number]))
            model.submit(number * 1000, MEMBERS[number % 4], frame)
        return model.collect(FOREVER)

    assert run() == run()
