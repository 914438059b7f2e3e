"""Each fault of a CAN bus, on the wire and in the trace.  At 1 Mbit/s a bit takes 1 us; an empty frame 0 has 50."""

from random import Random
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.bus import Delivery
from fieldrig.clock import MS, US, S
from fieldrig_bus.can.codec import CanMessage
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.can.given_fault import MODELS
from fieldrig_bus.can.model import CanBusModel
from fieldrig_bus.can.notices import BusState, CanError, CanState, FaultNote
from fieldrig_bus.can.outsiders import OutsidersSettings
from fieldrig_bus.can.virtual import CanVirtual

SHORT = CanFrame(0)
LATER = 10 * S


def bus(*faults: dict[str, Any], bitrate: int | None = 1_000_000, seed: int = 7) -> CanBusModel:
    model = CanVirtual("can0", OutsidersSettings.model_validate({"bitrate": bitrate, "faults": list(faults)})).model()
    model.begin(0, Random(f"{seed}/can0"))
    for member in ("a", "b", "c"):
        model.join(member)
        model.listen(0, member, ["own", [0, 0]])
    return model


def heard(model: CanBusModel, until_ns: int = LATER) -> list[tuple[int, str, Any, tuple[str, ...]]]:
    """Instant (us), sender, message and receivers of each frame."""
    return [
        (each.time_ns // US, each.sender, each.message, tuple(each.receivers))
        for each in model.collect(until_ns)
        if isinstance(each.message, CanFrame)
    ]


def notes(deliveries: list[Delivery[CanMessage]]) -> list[tuple[int, str, str]]:
    return [
        (each.time_ns // US, each.sender, each.message.what)
        for each in deliveries
        if isinstance(each.message, FaultNote)
    ]


def test_a_dropped_frame_is_on_the_wire_but_no_member_gets_it() -> None:
    model = bus({"what": "drop", "identifier": 0, "count": 1})
    model.submit(0, "a", SHORT)
    model.submit(0, "a", SHORT)
    assert heard(model) == [(50, "a", SHORT, ("a",)), (103, "a", SHORT, ("a", "b", "c"))]


@pytest.mark.parametrize("sender", ["a", "b"])
def test_a_frame_of_one_sender_is_dropped_where_another_sends_the_same_at_once(sender: str) -> None:
    """Once, the frame of the other sender was dropped, too, as both are one frame on the wire."""
    other = "b" if sender == "a" else "a"
    for order in ("ab", "ba"):
        model = bus({"what": "drop", "node": sender, "identifier": 0})
        for member in order:
            model.submit(0, member, SHORT)
        came = model.collect(LATER)
        frames = {each.sender: set(each.receivers) for each in came if isinstance(each.message, CanFrame)}
        assert frames == {sender: {sender}, other: {other, "c"}}, "the sender of a frame does not receive it"
        assert [note[1:] for note in notes(list(came))] == [(sender, "dropped")]


def test_a_frame_is_dropped_for_one_receiver_only() -> None:
    model = bus({"what": "drop", "receivers": ["b"]})
    model.submit(0, "a", SHORT)
    assert heard(model) == [(50, "a", SHORT, ("a", "c"))]


def test_every_application_is_in_the_trace() -> None:
    model = bus({"what": "drop", "node": "a"}, {"what": "duplicate", "identifier": 0, "count": 1})
    model.submit(0, "a", SHORT)
    model.submit(0, "b", CanFrame(1))
    assert notes(model.collect(LATER)) == [(50, "a", "dropped"), (50, "a", "duplicated")]


def test_a_delayed_frame_keeps_those_behind_it_back() -> None:
    model = bus({"what": "delay", "identifier": 0, "delay_ms": 2})
    model.submit(0, "a", SHORT)
    model.submit(0, "a", CanFrame(1))
    model.submit(0, "b", CanFrame(2))
    assert [(party, message.identifier) for _, party, message, _ in heard(model)] == [("b", 2), ("a", 0), ("a", 1)]


def test_a_delayed_frame_starts_so_much_later() -> None:
    model = bus({"what": "delay", "node": "a", "delay_ms": 2})
    model.submit(0, "a", SHORT)
    assert heard(model)[0][0] == 2050


def test_a_duplicated_frame_comes_twice_and_is_confirmed_once() -> None:
    model = bus({"what": "duplicate", "count": 1})
    model.submit(0, "a", SHORT)
    assert heard(model) == [(50, "a", SHORT, ("a", "b", "c")), (103, "a", SHORT, ("b", "c"))]


@pytest.mark.parametrize(("how", "data"), [({"data": "ff"}, "ff02"), ({"xor": "00 03"}, "0101")])
def test_replaced_data_come_with_a_right_crc(how: dict[str, str], data: str) -> None:
    model = bus({"what": "replace", **how})
    model.submit(0, "a", CanFrame(1, b"\x01\x02"))
    (others, own) = heard(model)
    assert others[2:] == (CanFrame(1, bytes.fromhex(data)), ("b", "c"))
    assert own[2:] == (CanFrame(1, b"\x01\x02"), ("a",))
    assert model.statistics(LATER)["error_frames"] == 0


def test_a_corrupted_frame_is_sent_again() -> None:
    model = bus({"what": "corrupt", "count": 3})
    model.submit(0, "a", SHORT)
    assert len(heard(model)) == 1
    assert model.statistics(LATER)["error_frames"] == model.statistics(LATER)["retransmissions"] == 3


def test_permanent_corruption_of_one_node_takes_it_off_the_bus() -> None:
    model = bus({"what": "corrupt", "node": "a", "duration_ms": 20})
    model.submit(0, "a", SHORT)
    states = [
        each.message.state
        for each in model.collect(10 * MS)
        if isinstance(each.message, BusState) and each.sender == "a"
    ]
    assert states[:3] == [CanState.WARNING, CanState.PASSIVE, CanState.BUS_OFF]


def test_a_babbling_idiot_holds_up_higher_identifiers() -> None:
    model = bus({"what": "babble", "node": "b", "identifier": 0, "duration_ms": 1})
    model.submit(1, "a", CanFrame(1))
    frames = heard(model)
    assert {party for _, party, _, _ in frames[:-1]} == {"b"}
    assert frames[-1][1] == "a"
    assert frames[-1][0] > 1000


def test_a_babbling_idiot_has_an_identifier_of_its_format() -> None:
    model = bus()
    with pytest.raises(ValueError, match="identifier 0x900 has 29 bits: expected at most 0x7ff, or extended: true"):
        model.add_fault(0, {"what": "babble", "node": "b", "identifier": 0x900, "extended": False})
    model.add_fault(0, {"what": "babble", "node": "b", "identifier": 0x900, "count": 1})
    assert [(frame.identifier, frame.is_extended) for _, _, frame, _ in heard(model)] == [(0x900, True)]


def test_a_babbling_idiot_has_a_period_and_a_count() -> None:
    model = bus({"what": "babble", "node": "b", "identifier": 0, "period_ms": 1, "count": 3})
    assert [at for at, _, _, _ in heard(model)] == [50, 1050, 2050]


@pytest.mark.parametrize("bitrate", [250_000, 800_000, 2_000_000])
def test_a_wrong_bit_rate_makes_everybody_see_errors(bitrate: int) -> None:
    model = bus({"what": "wrong_bit_rate", "node": "c", "bitrate": bitrate, "duration_ms": 50})
    model.submit(0, "a", CanFrame(0x123, b"\x55"))
    deliveries = model.collect(40 * MS)
    assert sum(isinstance(each.message, CanError) for each in deliveries) > 5
    frames = [each.receivers for each in deliveries if isinstance(each.message, CanFrame)]
    assert frames == [("a", "b")]  # when c is error passive and destroys nothing any more
    (fault,) = model.all_faults(40 * MS).values()
    assert fault["applied"] == model.statistics(40 * MS)["error_frames"] > 0
    model.submit(40 * MS, "c", CanFrame(0x123, b"\x55"))
    assert [each for each in model.collect(49 * MS) if isinstance(each.message, CanFrame)] == []


def test_a_recessive_wire_takes_its_transmitter_off() -> None:
    model = bus({"what": "short", "level": "recessive", "duration_ms": 5})
    model.submit(0, "a", SHORT)
    states = [(each.sender, each.message.state) for each in model.collect(4 * MS) if isinstance(each.message, BusState)]
    assert ("a", CanState.BUS_OFF) in states
    assert {party for party, _ in states} == {"a"}


def test_a_short_without_end_blocks_until_it_is_cleared() -> None:
    model = bus({"what": "short"})
    model.submit(1, "a", SHORT)
    assert heard(model) == []
    assert model.next_ns() is None
    model.clear_fault(LATER, 1)
    assert heard(model, 2 * LATER) == [(LATER // US + 11 + 50, "a", SHORT, ("a", "b", "c"))]


def received_by_a(seed: int) -> list[int]:
    model = bus({"what": "drop", "probability": 0.5}, seed=seed)
    for number in range(200):
        model.submit(number * MS, "a", CanFrame(number))
    return [message.identifier for _, _, message, party in heard(model) if party == ("a",)]


@pytest.mark.long
def test_chance_comes_from_the_seed() -> None:
    assert received_by_a(1) == received_by_a(1) != received_by_a(2)
    assert 70 < len(received_by_a(1)) < 130


def test_faults_come_and_go_at_run_time() -> None:
    model = bus()
    number = model.add_fault(S, {"what": "drop", "start_ms": 1, "duration_ms": 2})
    assert model.all_faults(S) == {
        number: {"what": "drop", "start_ms": 1, "duration_ms": 2, "state": "waiting", "applied": 0}
    }
    for at_ns in (S, S + 2 * MS, S + 4 * MS):
        model.submit(at_ns, "a", SHORT)
    assert [party for _, _, _, party in heard(model)] == [("a", "b", "c"), ("a",), ("a", "b", "c")]
    assert model.all_faults(LATER)[number]["state"] == "over"
    model.clear_fault(LATER, number)
    assert model.all_faults(LATER) == {}
    with pytest.raises(ValueError, match="there is no fault 1"):
        model.clear_fault(LATER, number)


@pytest.mark.parametrize(
    ("fault", "complaint"),
    [
        ({"what": "explode"}, "no fault 'explode'\nthere are: drop, delay"),
        ({"what": "corupt"}, "no fault 'corupt'\ndid you mean corrupt"),
        ({"what": ["drop"]}, "no fault .'drop'"),
        ({}, "what: this key is missing\nthere are: drop"),
        ({"what": "drop", "identifer": 3}, "identifer: there is no such key\ndid you mean identifier"),
        ({"what": "drop", "mask": 3}, "expected an identifier beside it"),
        ({"what": "drop", "probability": "2"}, "probability: 2 .*\n.* a number"),
        ({"what": "drop", "count": "[many"}, "count: '\\[many' is not a value"),
        ({"what": "delay"}, "delay_ms: .*\n.* a number"),
        ({"what": "replace"}, "^expected either data or xor"),
        ({"what": "replace", "data": "xy"}, "expected hex digits"),
        ({"what": "drop", "node": 5}, "node: 5 .*\n.* text"),
    ],
)
def test_a_wrong_fault_is_refused_with_what_was_expected(fault: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValueError, match=complaint):
        bus().add_fault(0, fault)


def test_values_may_be_texts_as_people_type_them() -> None:
    model = bus()
    typed = {"what": "replace", "identifier": "0x185", "probability": "1", "extended": "false", "data": "0102"}
    number = model.add_fault(0, typed)
    assert model.all_faults(0)[number].items() >= {"identifier": 0x185, "extended": False, "data": "0102"}.items()
    number = model.add_fault(0, {"what": "drop", "receivers": "[b, c]", "start_ms": "1e3", "node": "5"})
    assert model.all_faults(0)[number].items() >= {"receivers": ["b", "c"], "start_ms": 1000, "node": "5"}.items()


NUMBERS = st.integers(0) | st.floats(0) | st.sampled_from([1, 0.5, "0x10", ".inf", "1e400"])
BY_KEY: dict[str, st.SearchStrategy[Any]] = {
    **dict.fromkeys(("node", "level", "data", "xor"), st.sampled_from(["a", "recessive", "0102", "zz", "", 5])),
    "receivers": st.just(["a"]) | st.just("[b, c]") | st.text(max_size=4),
    "extended": st.booleans() | st.just("true"),
}


def given_to(what: str) -> st.SearchStrategy[dict[str, Any]]:
    keys = {key: BY_KEY.get(key, NUMBERS) for key in MODELS[what].model_fields if key != "what"}
    needed = {key: value for key, value in keys.items() if MODELS[what].model_fields[key].is_required()}
    others = {key: value for key, value in keys.items() if key not in needed}
    return st.fixed_dictionaries({"what": st.just(what), **needed}, optional=others)


@pytest.mark.long
@settings(deadline=None, max_examples=300)
@given(st.sampled_from(sorted(MODELS)).flatmap(given_to))
def test_any_fault_is_accepted_or_refused(fault: dict[str, Any]) -> None:
    model = bus()
    try:
        model.add_fault(0, fault)
    except ValueError:
        assert model.all_faults(0) == {}
    else:
        model.submit(0, "a", SHORT)
        model.collect(MS)


def test_a_short_that_is_over_when_it_begins_delays_nothing() -> None:
    model = bus()
    model.add_fault(0, {"what": "short", "start_ms": 0.1, "duration_ms": 1e-9})
    model.submit(0, "a", SHORT)
    assert [delivery.message for delivery in model.collect(MS)] == [SHORT]


def test_without_bit_times_there_are_no_errors_to_make() -> None:
    with pytest.raises(ValueError, match="only on a bus with a bitrate"):
        bus(bitrate=None).add_fault(0, {"what": "corrupt"})
    with pytest.raises(ValueError, match=r"faults\.0: short needs a bus with a bitrate"):
        bus({"what": "short"}, bitrate=None)


def test_without_bit_times_frames_may_still_be_lost() -> None:
    model = bus({"what": "drop", "count": 1}, bitrate=None)
    model.submit(0, "a", SHORT)
    model.submit(0, "a", SHORT)
    assert [party for _, _, _, party in heard(model)] == [("a",), ("a", "b", "c")]
