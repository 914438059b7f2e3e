"""Laws of any CAN bus with errors and injected faults, for any frames."""

from random import Random
from typing import Any, NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Delivery
from fieldrig.clock import US, S
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.error_counters import state_of
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.model import CanBusModel
from fieldrig_bus.can.notices import CanState, FaultNote

MEMBERS = ["a", "b", "c"]
LATER = 20 * S


class Asked(NamedTuple):
    asked_ns: int
    member: str
    frame: CanFrame


frames = st.builds(CanFrame, st.integers(0, 3), st.binary(max_size=2)) | st.builds(
    lambda identifier, data: CanFrame(identifier, data, is_fd=True), st.integers(0, 3), st.binary(max_size=2)
)
asked_frames = st.lists(
    st.builds(Asked, st.integers(0, 3000).map(lambda us: us * US), st.sampled_from(MEMBERS), frames), max_size=10
).map(lambda drawn: sorted(drawn, key=lambda asked: asked.asked_ns))

times = {"start_ms": st.sampled_from([0, 0.1, 1]), "duration_ms": st.sampled_from([0.005, 0.1, 2])}
often = {"count": st.integers(1, 40), "probability": st.sampled_from([0.3, 1])}
whom = {"identifier": st.integers(0, 3), "node": st.sampled_from(MEMBERS)}


def of(what: str, required: dict[str, Any], optional: dict[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    return st.fixed_dictionaries({"what": st.just(what), **required}, optional=optional)


faults = st.lists(
    of("drop", {}, {**times, **often, **whom})
    | of("delay", {"delay_ms": st.sampled_from([0.05, 3])}, {**times, **often, **whom})
    | of("duplicate", {}, {**times, **often, **whom})
    | of("replace", {"data": st.just("ff 00")}, {**times, **often, **whom})
    | of("corrupt", {"count": st.integers(1, 40)}, {**times, **whom, "bit": st.integers(0, 80)})
    | of("error_frame", {"count": st.integers(1, 40)}, {**times, **whom, "bit": st.integers(0, 80)})
    | of("short", times, {"level": st.sampled_from(["dominant", "recessive"])})
    | of(
        "wrong_bit_rate",
        {**times, "node": st.sampled_from(MEMBERS), "bitrate": st.sampled_from([250_000, 800_000])},
        {},
    )
    | of("babble", {**times, "node": st.sampled_from(MEMBERS), "identifier": st.integers(0, 3)}, {"count": st.just(5)}),
    max_size=3,
)


def model_with(asked_frames: list[Asked], faults: list[dict[str, Any]], **options: Any) -> CanBusModel:
    model = CanBusModel(500_000, **options)
    model.begin(0, Random("7/can0"))
    for member in MEMBERS:
        model.join(member)
        model.listen(0, member, ["own", "errors", "state", [0, 0]])
    model.join("d")  # acknowledges; otherwise three members that send the same frame at once would repeat it forever
    for fault in faults:
        model.add_fault(0, fault)
    for asked in asked_frames:
        model.submit(asked.asked_ns, asked.member, asked.frame)
    return model


def stepped(model: CanBusModel) -> list[Delivery[CanMessage]]:
    deliveries = []
    while (next_ns := model.next_ns()) is not None and next_ns < LATER:
        step = model.collect(next_ns)
        assert step, "something was promised"
        assert all(each.time_ns == next_ns for each in step)
        for member in model.members.values():
            assert 0 <= member.rec <= 255
            assert member.tec >= 0
            assert member.state is state_of(member.tec, member.rec)
            assert member.tec < 256 or not member.queue
        deliveries += step
    return deliveries


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(asked_frames, faults)
def test_counters_keep_to_the_rules_and_time_never_runs_back(
    asked_frames: list[Asked], faults: list[dict[str, Any]]
) -> None:
    instants = [each.time_ns for each in stepped(model_with(asked_frames, faults))]
    assert instants == sorted(instants)


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(asked_frames, faults)
def test_it_does_not_matter_in_how_many_steps_it_is_collected(
    asked_frames: list[Asked], faults: list[dict[str, Any]]
) -> None:
    assert stepped(model_with(asked_frames, faults)) == model_with(asked_frames, faults).collect(LATER)


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(asked_frames, faults)
def test_a_frame_is_sent_or_counted_as_lost(asked_frames: list[Asked], faults: list[dict[str, Any]]) -> None:
    model = model_with(asked_frames, faults)
    deliveries = model.collect(LATER)
    sent = model.statistics(LATER)["frames"]
    notes = [each.message.what for each in deliveries if isinstance(each.message, FaultNote)]
    babbled = sum(fault["applied"] for fault in model.all_faults(LATER).values() if fault["what"] == "babble")
    assert sent - notes.count("duplicated") - babbled + model.statistics(LATER)["lost_frames"] == len(asked_frames)
    assert model.statistics(LATER)["waiting_frames"] == 0


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(asked_frames)
def test_a_quarrel_of_two_about_one_identifier_loses_nothing(asked_frames: list[Asked]) -> None:
    """Both frames arrive in the order of asking if another member acknowledges them."""
    asked_frames = [asked for asked in asked_frames if asked.member != "c"]
    deliveries = model_with(asked_frames, []).collect(LATER)
    for member in MEMBERS:
        assert [
            each.message for each in deliveries if each.sender == member and isinstance(each.message, CanFrame)
        ] == [asked.frame for asked in asked_frames if asked.member == member]


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(asked_frames, faults)
def test_when_all_is_well_again_the_bus_recovers(asked_frames: list[Asked], faults: list[dict[str, Any]]) -> None:
    model = model_with(asked_frames, faults)
    model.collect(LATER)
    for number in [*model.all_faults(LATER)]:
        model.clear_fault(LATER, number)
    model.collect(2 * LATER)
    assert all(member.state is not CanState.BUS_OFF for member in model.members.values())
    model.submit(2 * LATER, "a", CanFrame(0x7FF))
    (delivery,) = [each for each in model.collect(3 * LATER) if isinstance(each.message, CanFrame)]
    assert delivery.receivers == ("a", "b", "c")
