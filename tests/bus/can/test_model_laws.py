"""What holds on any CAN bus whatever is asked of it, and when it is told."""

from dataclasses import replace
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Delivery
from fieldrig.clock import US, S
from fieldrig_bus.can.arbitration import priority
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.length import classical_bits
from fieldrig_bus.can.model import CanBusModel, CanMessage

MEMBERS = ["a", "b", "c", "d"]
BITRATE = 500_000
BIT_NS = S // BITRATE
INTERMISSION_NS = 3 * BIT_NS
FOREVER = 1000 * S


class Wish(NamedTuple):
    asked_ns: int
    member: str
    frame: CanFrame


frames = st.builds(CanFrame, st.integers(0, 0x7FF), st.binary(max_size=8), is_extended=st.booleans()) | st.builds(
    CanFrame, st.integers(0, 3), is_remote=st.just(True), remote_length=st.integers(0, 8)
)


def of_its_own(wish: Wish) -> Wish:
    """No two members share an identifier: the last bits say who it is.  (`test_error_laws` has the others.)"""
    identifier = wish.frame.identifier & ~3 | MEMBERS.index(wish.member)
    return wish._replace(frame=replace(wish.frame, identifier=identifier))


instants = st.integers(0, 3000).map(lambda us: us * US)
wishes = st.lists(st.builds(Wish, instants, st.sampled_from(MEMBERS), frames).map(of_its_own))
in_time = wishes.map(lambda drawn: sorted(drawn, key=lambda wish: wish.asked_ns))


def model_with(wishes: list[Wish]) -> CanBusModel:
    model = CanBusModel(BITRATE)
    for member in MEMBERS:
        model.join(member)
        model.listen(0, member, None)
    for wish in wishes:
        model.submit(wish.asked_ns, wish.member, wish.frame)
    return model


def start_ns(delivery: Delivery[CanMessage]) -> int:
    return delivery.time_ns + INTERMISSION_NS - bits_of(delivery) * BIT_NS


def bits_of(delivery: Delivery[CanMessage]) -> int:
    assert isinstance(delivery.message, CanFrame)
    return classical_bits(delivery.message)


@settings(max_examples=200, deadline=None)
@given(in_time)
def test_every_frame_arrives_once_and_first_in_first_out(wishes: list[Wish]) -> None:
    deliveries = model_with(wishes).collect(FOREVER)
    for member in MEMBERS:
        assert [each.message for each in deliveries if each.sender == member] == [
            wish.frame for wish in wishes if wish.member == member
        ]


@settings(max_examples=200, deadline=None)
@given(in_time)
def test_frames_never_overlap_and_the_winner_is_the_lowest_that_waits(wishes: list[Wish]) -> None:
    waiting = {member: [wish for wish in wishes if wish.member == member] for member in MEMBERS}
    free_ns = 0
    for delivery in model_with(wishes).collect(FOREVER):
        heads = [queue[0] for queue in waiting.values() if queue]
        start = start_ns(delivery)
        assert start == max(free_ns, min(wish.asked_ns for wish in heads))
        rivals = [wish for wish in heads if wish.asked_ns <= start]
        winner = min(rivals, key=lambda wish: (priority(wish.frame), MEMBERS.index(wish.member)))
        assert (winner.member, winner.frame) == (delivery.sender, delivery.message)
        waiting[winner.member].pop(0)
        free_ns = delivery.time_ns + INTERMISSION_NS


@settings(max_examples=100, deadline=None)
@given(wishes, st.integers(0, 4000))
def test_the_bus_carries_no_more_bits_than_fit(wishes: list[Wish], until_us: int) -> None:
    model = model_with(wishes)
    deliveries = model.collect(until_us * US)
    busy_bits = sum(bits_of(each) - 3 for each in deliveries)
    assert busy_bits * BIT_NS <= until_us * US
    assert all(each.time_ns <= until_us * US for each in deliveries)


@settings(max_examples=100, deadline=None)
@given(in_time)
def test_it_does_not_matter_in_how_many_steps_it_is_collected(wishes: list[Wish]) -> None:
    stepped: list[Delivery[CanMessage]] = []
    model = model_with(wishes)
    while (next_ns := model.next_ns()) is not None:
        step = model.collect(next_ns)
        assert [each.time_ns for each in step] == [next_ns]
        stepped += step
    assert stepped == model_with(wishes).collect(FOREVER)


@settings(max_examples=200, deadline=None)
@given(in_time)
def test_the_order_in_which_members_tell_does_not_matter(wishes: list[Wish]) -> None:
    """Told late, but before the collecting: only the order within one member counts."""
    by_member = sorted(wishes, key=lambda wish: MEMBERS.index(wish.member))
    assert model_with(by_member).collect(FOREVER) == model_with(wishes).collect(FOREVER)


@settings(max_examples=200, deadline=None)
@given(wishes)
def test_told_late_or_not_time_never_runs_back(wishes: list[Wish]) -> None:
    model = model_with([])
    ends = [0]
    for wish in wishes:  # in any order of time, with collecting in between
        model.submit(wish.asked_ns, wish.member, wish.frame)
        for delivery in model.collect(1500 * US):
            assert start_ns(delivery) >= ends[-1] + (INTERMISSION_NS if ends[-1] else 0)
            ends.append(delivery.time_ns)
    model.collect(FOREVER)
    assert model.statistics(FOREVER)["frames"] == len(wishes)


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
