"""The door of a service: connections that are let in, those that have to go, and the log of it."""

import logging

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.outside.limits import QUIET_S, Door, Limits, Reached


class Time:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


class Visitor:
    def __init__(self) -> None:
        self.was_shut = False
        self.is_pending = False

    def shut(self) -> None:
        self.was_shut = True


def come(door: Door, peer: str) -> Visitor | None:
    """Return the connection of this peer; None if it was refused."""
    if not door.is_open_to(peer):
        return None
    visitor = Visitor()
    door.enter(visitor, peer)
    return visitor


def come_and_speak(door: Door, peer: str) -> Visitor:
    visitor = come(door, peer)
    assert visitor is not None
    door.heard(visitor)
    return visitor


def test_a_quarter_of_the_places_is_for_others() -> None:
    door = Door("http", Limits(connections=8))
    for _ in range(6):
        come_and_speak(door, "10.0.0.1")
    assert come(door, "10.0.0.1") is None
    assert come(door, "10.0.0.2") is not None
    assert door.reached.figures() == {"connections over the limit of a peer": 1.0}


def test_a_single_place_is_for_whoever_comes() -> None:
    assert Limits(connections=1).of_a_peer == 1


def test_a_silent_connection_gives_way_to_a_new_one() -> None:
    door = Door("ftp", Limits(connections=4))
    first, *others = [come(door, f"10.0.0.{number}") for number in range(4)]
    assert come(door, "10.0.0.9") is not None
    assert first is not None
    assert first.was_shut
    assert not any(other is None or other.was_shut for other in others)
    assert len(door) == 4
    assert door.reached.figures() == {"connections over the limit": 1.0}


def test_a_connection_whose_first_message_waits_for_its_turn_stays() -> None:
    door = Door("http", Limits(connections=4))
    there = [come(door, f"10.0.0.{number}") for number in range(4)]
    for visitor in (there[0], there[1]):
        assert visitor is not None
        visitor.is_pending = True
    assert come(door, "10.0.0.9") is not None
    assert [visitor is not None and visitor.was_shut for visitor in there] == [False, False, True, False]


def test_a_new_connection_is_refused_where_the_first_messages_of_all_others_wait_for_their_turn() -> None:
    door = Door("http", Limits(connections=4))
    there = [come(door, f"10.0.0.{number}") for number in range(4)]
    for visitor in there:
        assert visitor is not None
        visitor.is_pending = True
    assert come(door, "10.0.0.9") is None
    assert not any(visitor is None or visitor.was_shut for visitor in there)
    assert door.reached.figures() == {"connections over the limit": 1.0}


def test_connections_that_have_spoken_stay() -> None:
    door = Door("ftp", Limits(connections=4))
    there = [come_and_speak(door, f"10.0.0.{number}") for number in range(4)]
    assert come(door, "10.0.0.9") is None
    assert not any(visitor.was_shut for visitor in there)


def test_with_replacement_the_longest_idle_one_goes() -> None:
    door = Door("Modbus", Limits(connections=4, replaces_idle=True))
    there = [come_and_speak(door, f"10.0.0.{number}") for number in range(4)]
    door.heard(there[0])
    assert come(door, "10.0.0.9") is not None
    assert [visitor.was_shut for visitor in there] == [False, True, False, False]


def test_the_first_message_has_its_time() -> None:
    now = Time()
    door = Door("http", Limits(first_message_s=30.0), now)
    assert door.next_s() is None
    silent, speaking = come(door, "10.0.0.1"), come_and_speak(door, "10.0.0.1")
    assert door.next_s() == 130.0
    now.now_s = 129.9
    door.expire()
    assert len(door) == 2
    now.now_s = 130.0
    door.expire()
    assert silent is not None
    assert (silent.was_shut, speaking.was_shut) == (True, False)
    assert len(door) == 1
    assert door.next_s() is None
    assert door.reached.figures() == {"connections without a message": 1.0}


def test_a_service_where_clients_may_only_listen_has_no_such_time() -> None:
    door = Door("serial line", Limits(first_message_s=None))
    come(door, "10.0.0.1")
    assert door.next_s() is None


def test_the_number_of_silent_connections_may_have_a_limit_of_its_own() -> None:
    door = Door("hub", Limits(connections=100, silent=2))
    visitors = [come(door, "10.0.0.1") for _ in range(3)]
    assert [visitor is not None and visitor.was_shut for visitor in visitors] == [True, False, False]


def test_a_limit_that_is_reached_all_the_time_is_logged_now_and_then(caplog: pytest.LogCaptureFixture) -> None:
    now = Time()
    reached = Reached("http at 127.0.0.1:8080", now)
    with caplog.at_level(logging.WARNING):
        for _ in range(1000):
            reached.note("connections over the limit", "64 connections are open; another one is refused")
        now.now_s += QUIET_S
        reached.note("connections over the limit", "64 connections are open; another one is refused")
    assert [record.getMessage().partition(" (")[2] for record in caplog.records] == [
        "connections over the limit: 1 so far)",
        "connections over the limit: 1001 so far)",
    ]
    assert reached.figures() == {"connections over the limit": 1001.0}


@given(
    st.integers(1, 9),
    st.booleans(),
    st.lists(st.tuples(st.sampled_from(["come", "speak", "leave", "wait"]), st.integers(0, 3), st.integers(0, 99))),
)
def test_the_limits_hold_whatever_happens(most: int, replaces_idle: bool, events: list[tuple[str, int, int]]) -> None:
    now = Time()
    limits = Limits(connections=most, replaces_idle=replaces_idle)
    door = Door("any", limits, now)
    there: list[tuple[Visitor, str]] = []
    for what, peer, number in events:
        if what == "come":
            visitor = come(door, str(peer))
            if visitor is not None:
                there.append((visitor, str(peer)))
        elif what == "wait":
            now.now_s += number
            door.expire()
        elif there:
            visitor, other = there[number % len(there)]
            if what == "speak":
                door.heard(visitor)
            else:
                door.leave(visitor)
                there.remove((visitor, other))
        there = [(visitor, peer) for visitor, peer in there if not visitor.was_shut]
        assert len(door) == len(there) <= most
        assert all(sum(other == peer for _, other in there) <= limits.of_a_peer for _, peer in there)
