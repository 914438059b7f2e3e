"""Messages of OPC UA between processes: what is sent arrives, and nothing else does."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.opcua import codec
from fieldrig_bus.opcua import message as opc
from fieldrig_bus.opcua.model import SERVER, OpcUaModel

texts = st.text(st.characters(codec="utf-8"), max_size=20)
numbers = st.integers(0, 2**31)
single = st.booleans() | st.integers(-(2**63), 2**63 - 1) | st.floats(allow_nan=False) | texts
values = single | st.lists(single, max_size=4)
limits = st.none() | st.floats(allow_nan=False, allow_infinity=False)
arguments = st.lists(st.builds(opc.Argument, texts, texts, texts, st.booleans()), max_size=3).map(tuple)
statuses = st.sampled_from(opc.Status)
nodes = st.builds(
    opc.Node, texts, texts, texts, st.sampled_from(opc.Kind), texts, st.none() | numbers, st.booleans(), st.booleans(),
    texts, texts, limits, limits, st.lists(st.tuples(texts, st.integers(-100, 100)), max_size=3).map(tuple),
    arguments, arguments,
)  # fmt: skip
outcomes = st.builds(
    opc.Outcome, statuses, st.none() | values, texts, st.lists(values, max_size=3).map(tuple),
    st.lists(statuses, max_size=3).map(tuple),
)  # fmt: skip
messages: st.SearchStrategy[opc.OpcUaMessage] = st.one_of(
    st.builds(opc.Offer, texts, texts, numbers),
    st.builds(opc.Browse, texts, numbers, texts, numbers),
    st.builds(opc.Find, texts, numbers, texts),
    st.builds(opc.Call, texts, numbers, texts, st.lists(values, max_size=3).map(tuple)),
    st.builds(opc.Read, texts, numbers, st.lists(texts, max_size=3).map(tuple)),
    st.builds(opc.Write, texts, numbers, texts, values),
    st.builds(opc.Nodes, numbers, st.lists(nodes, max_size=3).map(tuple), st.booleans()),
    st.builds(opc.Outcomes, numbers, st.lists(outcomes, max_size=3).map(tuple)),
)


@pytest.mark.long
@given(messages)
def test_a_message_arrives_as_it_was_sent(message: opc.OpcUaMessage) -> None:
    codec.check_sent(message)
    assert codec.decode(codec.encode(message)) == message
    assert codec.show(message)


@given(st.binary() | messages.map(codec.encode).flatmap(lambda data: st.integers(0, len(data)).map(lambda n: data[:n])))
def test_other_bytes_are_refused_with_a_value_error(data: bytes) -> None:
    with suppress(ValueError):
        codec.check_sent(codec.decode(data))


def test_a_number_that_is_not_finite_arrives() -> None:
    [outcome] = codec.decode(codec.encode(opc.Outcomes(1, (opc.Outcome(opc.Status.GOOD, float("nan")),)))).outcomes  # type: ignore[union-attr]
    assert outcome.value != outcome.value


def test_what_is_too_long_can_t_be_sent() -> None:
    with pytest.raises(ValueError, match="paths"):
        codec.check_sent(opc.Read("plc", 1, ("x",) * (opc.MOST_PATHS + 1)))
    with pytest.raises(ValueError, match="nodes"):
        codec.check_sent(opc.Nodes(1, (opc.Node("x", "", "x"),) * (opc.MOST_NODES + 1)))
    with pytest.raises(TypeError):
        codec.check_sent("text")


def test_requests_go_to_their_device_and_answers_to_the_server() -> None:
    model = OpcUaModel()
    for member in ("plc", SERVER, "tank"):
        model.join(member)
    model.submit(5, SERVER, opc.Find("tank", 1, "level"))
    model.submit(6, "tank", opc.Nodes(1, ()))
    model.submit(7, SERVER, opc.Find("gone", 2, "level"))
    assert [(delivery.time_ns, delivery.receivers) for delivery in model.collect(10)] == [
        (5, ("tank",)),
        (6, (SERVER,)),
        (7, ()),
    ]
    assert model.statistics(10) == {"requests": 2.0, "answers": 1.0}


def test_a_server_that_starts_later_gets_the_offers() -> None:
    model = OpcUaModel()
    model.join("plc")
    model.submit(1, "plc", opc.Offer("plc", "a PLC", 1))
    model.submit(2, "plc", opc.Offer("plc", "a PLC", 2))
    assert [delivery.receivers for delivery in model.collect(2)] == [(), ()]
    model.join(SERVER)
    model.listen(3, SERVER, None)
    assert [(delivery.message, delivery.receivers) for delivery in model.collect(3)] == [
        (opc.Offer("plc", "a PLC", 2), (SERVER,))
    ]
