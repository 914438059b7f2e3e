"""Bytes of a client are handled a message at a time, in turn with other clients."""

import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS, US, VirtualClock
from fieldrig.loop.pace import Pace, beside_a_cycle
from fieldrig.outside.portions import Hold, Portions

LENGTH = 4
"""Length of a message here, in bytes."""


class Client(Portions):
    """A client whose messages take 100 us each."""

    def __init__(self, clock: VirtualClock, pace: Pace | None, name: str, log: list[str]) -> None:
        super().__init__()
        self._clock, self._name, self._log = clock, name, log
        self.pace = pace
        self.handled = b""
        self.is_read = True

    def end_of_first(self, data: bytes) -> int:
        return min(LENGTH - len(self.handled) % LENGTH, len(data))

    def data_received(self, data: bytes) -> None:
        self.handled += data
        self._log.append(self._name)
        self._clock.instant_ns += 100 * US

    def read_from_now(self, is_wanted: bool) -> None:
        self.is_read = is_wanted

    def feed(self, data: bytes) -> None:
        buffer = self.get_buffer(0)
        assert len(data) < len(buffer)
        buffer[: len(data)] = data
        self.buffer_updated(len(data))


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> VirtualClock:
    clock = VirtualClock()
    monkeypatch.setattr(time, "monotonic_ns", clock.now_ns)
    monkeypatch.setattr(time, "process_time_ns", lambda: 0)
    return clock


def until_handled(clock: VirtualClock, client: Client, data: bytes) -> None:
    while client.handled != data:
        clock.advance_to(clock.now_ns() + MS)


@pytest.mark.parametrize("make", [Pace, beside_a_cycle])
def test_a_new_client_waits_for_one_message_of_each_other(clock: VirtualClock, make: type[Pace]) -> None:
    pace, log = make(clock), list[str]()
    for number in range(30):
        Client(clock, pace, str(number), log).feed(bytes(300 * LENGTH))
    clock.advance_to(clock.now_ns() + 100 * MS)
    polite, before = Client(clock, pace, "polite", log), len(log)
    polite.feed(bytes(LENGTH))
    until_handled(clock, polite, bytes(LENGTH))
    others = log[before : log.index("polite")]
    assert max(map(others.count, others)) == 1


@pytest.mark.parametrize("make", [Pace, beside_a_cycle])
def test_who_asks_now_and_then_waits_for_hardly_anyone(clock: VirtualClock, make: type[Pace]) -> None:
    pace, log = make(clock), list[str]()
    for number in range(30):
        Client(clock, pace, str(number), log).feed(bytes(300 * LENGTH))
    polite = Client(clock, pace, "polite", log)
    for count in range(1, 4):
        clock.advance_to(clock.now_ns() + 100 * MS)  # others have several turns each
        before = len(log)
        polite.feed(bytes(LENGTH))
        until_handled(clock, polite, bytes(count * LENGTH))
        waited = log.index("polite", before) - before
        assert waited <= (30 if count == 1 else 1)


def test_nothing_is_read_from_a_client_whose_messages_wait(clock: VirtualClock) -> None:
    pace, log = beside_a_cycle(clock), list[str]()
    client = Client(clock, pace, "client", log)
    client.feed(bytes(300 * LENGTH))
    assert 0 < len(log) < 300
    assert not client.is_read
    until_handled(clock, client, bytes(300 * LENGTH))
    assert client.is_read


def test_a_hold_stops_between_two_messages(clock: VirtualClock) -> None:
    pace, log = Pace(clock), list[str]()

    class Stopping(Client):
        def data_received(self, data: bytes) -> None:
            super().data_received(data)
            self.hold(Hold.OWN, len(log) == 2)

    client = Stopping(clock, pace, "client", log)
    client.feed(bytes(5 * LENGTH))
    clock.advance_to(clock.now_ns() + 100 * MS)
    assert len(log) == 2
    client.hold(Hold.OWN, False)
    clock.advance_to(clock.now_ns() + 100 * MS)
    assert (len(log), client.is_read) == (5, True)


@pytest.mark.long
@settings(deadline=None)
@given(parts=st.lists(st.binary(min_size=1, max_size=40), max_size=20), is_held=st.lists(st.booleans(), max_size=20))
def test_no_byte_is_lost_or_handled_twice(parts: list[bytes], is_held: list[bool]) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        clock = VirtualClock()
        monkeypatch.setattr(time, "monotonic_ns", clock.now_ns)
        pace = Pace(clock, share=0.5, slice_ns=150 * US)
        client = Client(clock, pace, "client", [])
        holds = iter(is_held)
        for part in parts:
            client.hold(Hold.HUB, next(holds, False))
            client.feed(part)
        client.hold(Hold.HUB, False)
        clock.advance_to(clock.now_ns() + 1000 * MS)
        assert client.handled == b"".join(parts)
