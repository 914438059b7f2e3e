"""Messages of OPC UA between processes: what is sent arrives, and nothing else does."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.opcua import codec
from fieldrig_bus.opcua.message import (
    MOST_NODES,
    MOST_PATHS,
    Browse,
    Call,
    Find,
    Kind,
    Node,
    Nodes,
    Offer,
    OpcUaMessage,
    Outcome,
    Outcomes,
    Read,
    Status,
    Write,
)
from fieldrig_bus.opcua.model import SERVER, OpcUaModel

texts = st.text(st.characters(codec="utf-8"), max_size=20)
numbers = st.integers(0, 2**31)
single = st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | texts
values = single | st.lists(single, max_size=4)
limits = st.none() | st.floats(allow_nan=False, allow_infinity=False)
nodes = st.builds(
    Node, texts, texts, texts, st.sampled_from(Kind), texts, st.none() | numbers, st.booleans(), st.booleans(), texts,
    texts, limits, limits, st.lists(st.tuples(texts, st.integers(-100, 100)), max_size=3).map(tuple),
)  # fmt: skip
outcomes = st.builds(Outcome, st.sampled_from(Status), st.none() | values, texts)
messages: st.SearchStrategy[OpcUaMessage] = st.one_of(
    st.builds(Offer, texts, texts, numbers),
    st.builds(Browse, texts, numbers, texts, numbers),
    st.builds(Find, texts, numbers, texts),
    st.builds(Call, texts, numbers, texts),
    st.builds(Read, texts, numbers, st.lists(texts, max_size=3).map(tuple)),
    st.builds(Write, texts, numbers, texts, values),
    st.builds(Nodes, numbers, st.lists(nodes, max_size=3).map(tuple), st.booleans()),
    st.builds(Outcomes, numbers, st.lists(outcomes, max_size=3).map(tuple)),
)


@given(messages)
def test_a_message_arrives_as_it_was_sent(message: OpcUaMessage) -> None:
    codec.check_sent(message)
    assert codec.decode(codec.encode(message)) == message
    assert codec.show(message)


@given(st.binary() | messages.map(codec.encode).flatmap(lambda data: st.integers(0, len(data)).map(lambda n: data[:n])))
def test_other_bytes_are_refused_with_a_value_error(data: bytes) -> None:
    with suppress(ValueError):
        codec.check_sent(codec.decode(data))


def test_a_number_that_is_not_finite_arrives() -> None:
    [outcome] = codec.decode(codec.encode(Outcomes(1, (Outcome(Status.GOOD, float("nan")),)))).outcomes  # type: ignore[union-attr]
    assert outcome.value != outcome.value


def test_what_is_too_long_can_t_be_sent() -> None:
    with pytest.raises(ValueError, match="paths"):
        codec.check_sent(Read("plc", 1, ("x",) * (MOST_PATHS + 1)))
    with pytest.raises(ValueError, match="nodes"):
        codec.check_sent(Nodes(1, (Node("x", "", "x"),) * (MOST_NODES + 1)))
    with pytest.raises(TypeError):
        codec.check_sent("text")


def test_requests_go_to_their_device_and_answers_to_the_server() -> None:
    model = OpcUaModel()
    for member in ("plc", SERVER, "tank"):
        model.join(member)
    model.submit(5, SERVER, Find("tank", 1, "level"))
    model.submit(6, "tank", Nodes(1, ()))
    model.submit(7, SERVER, Find("gone", 2, "level"))
    assert [(delivery.time_ns, delivery.receivers) for delivery in model.collect(10)] == [
        (5, ("tank",)),
        (6, (SERVER,)),
        (7, ()),
    ]
    assert model.statistics(10) == {"requests": 2.0, "answers": 1.0}


def test_a_server_that_starts_later_gets_the_offers() -> None:
    model = OpcUaModel()
    model.join("plc")
    model.submit(1, "plc", Offer("plc", "a PLC", 1))
    model.submit(2, "plc", Offer("plc", "a PLC", 2))
    assert [delivery.receivers for delivery in model.collect(2)] == [(), ()]
    model.join(SERVER)
    model.listen(3, SERVER, None)
    assert [(delivery.message, delivery.receivers) for delivery in model.collect(3)] == [
        (Offer("plc", "a PLC", 2), (SERVER,))
    ]
