"""Channels of a relay: both ends and the model between them."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from relay_deliveries import deliveries

from fieldrig_bus.ip.channel import COMPLETE, Channel
from fieldrig_bus.ip.message import LARGEST, WINDOW, Closed, Consumed, Ended, Offered, Opened, Portion, RelayMessage
from fieldrig_bus.ip.model import LEFT, REFUSED, RELAY, UNKNOWN, RelayModel
from fieldrig_bus.ip.stream import join


class Pair:
    """Two ends whose messages arrive at once."""

    def __init__(self) -> None:
        self.sent: list[RelayMessage] = []
        self.here = Channel("plc", 1, False, lambda message: self._pass(message, self.there))
        self.there = Channel("plc", 1, True, lambda message: self._pass(message, self.here))
        self.received = bytearray()
        self.there.on_data = self.received.extend

    def _pass(self, message: RelayMessage, end: Channel) -> None:
        self.sent.append(message)
        assert isinstance(message, Portion | Consumed | Ended | Closed)
        end.take(message)


def test_data_arrive_in_portions() -> None:
    pair = Pair()
    pair.here.send(bytes(LARGEST + 1))
    assert [len(message.data) for message in pair.sent if isinstance(message, Portion)] == [LARGEST, 1]
    assert len(pair.received) == LARGEST + 1


def test_a_paused_end_is_sent_a_window_and_no_more() -> None:
    pair = Pair()
    calls: list[int] = []
    pair.here.on_room = lambda: calls.append(pair.here.room)
    pair.there.pause()
    pair.here.send(bytes(3 * WINDOW))
    assert (sum(len(message.data) for message in pair.sent if isinstance(message, Portion)), pair.here.room) == (
        WINDOW,
        0,
    )
    pair.there.resume()
    assert (len(pair.received), len(calls)) == (3 * WINDOW, 1)


def test_an_end_comes_after_the_data_and_both_make_it_complete() -> None:
    pair = Pair()
    closings: list[str] = []
    pair.here.on_close = pair.there.on_close = closings.append
    pair.there.pause()
    pair.here.send(bytes(2 * WINDOW))
    pair.here.end()
    pair.there.end()
    assert closings == []
    pair.there.resume()
    assert (len(pair.received), closings) == (2 * WINDOW, [COMPLETE] * 2)
    assert pair.here.is_complete
    assert pair.there.is_complete


def test_an_abort_is_reported_to_the_other_end_only() -> None:
    pair = Pair()
    here: list[str] = []
    there: list[str] = []
    pair.here.on_close, pair.there.on_close = here.append, there.append
    pair.here.abort()
    pair.here.send(b"x")
    assert (here, there) == ([], ["aborted"])


@pytest.mark.parametrize("is_ended", [False, True])
def test_a_peer_that_breaks_the_rules_loses_the_channel(is_ended: bool) -> None:
    sent: list[RelayMessage] = []
    closings: list[str] = []
    channel = Channel("plc", 1, True, sent.append)
    channel.on_close = closings.append
    channel.pause()
    if is_ended:
        channel.take(Ended("plc", 1, False))
    else:
        for _ in range(WINDOW // LARGEST):
            channel.take(Portion("plc", 1, False, bytes(LARGEST)))
    channel.take(Portion("plc", 1, False, b"x"))
    assert len(closings) == 1
    assert isinstance(sent[-1], Closed)


@settings(deadline=None)
@given(st.lists(st.integers(1, 40_000), max_size=12), st.lists(st.booleans(), max_size=12))
def test_joined_streams_carry_everything(sizes: list[int], pauses: list[bool]) -> None:
    first, second = Pair(), Pair()
    join(first.there, second.here)
    closings: list[str] = []
    second.there.on_close = closings.append
    sent = bytearray()
    for place, size in enumerate(sizes):
        data = bytes((place,)) * size
        sent += data
        first.here.send(data)
        if pauses[place : place + 1] == [True]:
            second.there.pause()
        else:
            second.there.resume()
    first.here.end()
    second.there.end()
    second.there.resume()
    assert bytes(second.received) == bytes(sent)
    assert closings == [COMPLETE]


# The model


def relay() -> RelayModel:
    model = RelayModel()
    for member in ("plc", "web", "other"):
        model.join(member)
    model.submit(0, "web", Offered((80,)))
    model.submit(0, "plc", Opened("plc", 1, 80))
    deliveries(model)
    return model


def test_an_offer_reaches_those_that_are_there_and_those_that_come() -> None:
    model = RelayModel()
    model.join("web")
    model.join("plc")
    offer = Offered((80,))
    model.submit(0, "web", offer)
    assert deliveries(model) == [("web", offer, ("plc",))]
    model.join("late")
    model.listen(5, "late", None)
    assert deliveries(model) == [("web", offer, ("late",))]


def test_messages_go_to_the_other_end() -> None:
    model = relay()
    there, back = Portion("plc", 1, False, b"GET"), Portion("plc", 1, True, b"page")
    model.submit(1, "plc", there)
    model.submit(1, "web", back)
    assert deliveries(model) == [("plc", there, ("web",)), ("web", back, ("plc",))]


def test_a_port_that_no_member_offers_is_refused() -> None:
    model = relay()
    model.submit(1, "plc", Opened("plc", 2, 81))
    assert deliveries(model)[-1] == (RELAY, Closed("plc", 2, True, REFUSED), ("plc",))


@pytest.mark.parametrize(
    ("member", "message"),
    [
        ("other", Opened("plc", 7, 80)),
        ("other", Portion("plc", 1, False, b"x")),
        ("other", Portion("plc", 1, True, b"x")),
        ("plc", Portion("plc", 1, True, b"x")),
        ("web", Ended("plc", 1, False)),
    ],
)
def test_no_member_speaks_for_another_one(member: str, message: RelayMessage) -> None:
    model = relay()
    model.submit(1, member, message)
    assert deliveries(model)[0] == (member, message, ())


def test_data_of_an_unknown_channel_are_refused() -> None:
    model = relay()
    model.submit(1, "plc", Portion("plc", 9, False, b"x"))
    assert deliveries(model)[-1] == (RELAY, Closed("plc", 9, True, UNKNOWN), ("plc",))


@pytest.mark.parametrize(("member", "other", "is_answer"), [("web", "plc", True), ("plc", "web", False)])
def test_a_member_that_leaves_loses_its_channels(member: str, other: str, is_answer: bool) -> None:
    model = relay()
    model.leave(member)
    assert deliveries(model) == [(RELAY, Closed("plc", 1, is_answer, LEFT), (other,))]
    assert model.statistics(0)["channels"] == 0


def test_a_channel_is_forgotten_when_both_ends_have_ended() -> None:
    model = relay()
    model.submit(1, "plc", Ended("plc", 1, False))
    assert model.statistics(1)["channels"] == 1
    model.submit(1, "web", Ended("plc", 1, True))
    assert model.statistics(1) == {"channels": 0, "opened": 1, "refused": 0, "bytes": 0, "packets": 0}
