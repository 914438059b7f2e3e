"""The bytes of an outside client are passed to the line as it transmits them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S, VirtualClock
from fieldrig.testing import RecordedLink
from fieldrig_bus.sending_ahead import AHEAD_NS
from fieldrig_bus.serial.end import MOST_WAITING, LineEnd
from fieldrig_bus.serial.message import ControlLines, Format, SerialMessage


class Bench:
    def __init__(self, form: Format, is_paced: bool = True) -> None:
        self.clock = VirtualClock()
        self.link = RecordedLink[SerialMessage]()
        self.end = LineEnd(self.link, self.clock, form, is_paced)
        self.room: list[bool] = []
        self.end.on_room = self.room.append

    def sent(self) -> bytes:
        return b"".join(message for message in self.link.take() if isinstance(message, bytes))


@pytest.fixture
def bench() -> Bench:
    return Bench(Format(10_000))  # a character takes 1 ms


def test_line_is_fed_a_little_ahead(bench: Bench) -> None:
    bench.end.send(bytes(100))
    assert len(bench.sent()) == AHEAD_NS // MS
    bench.clock.advance_to(60 * MS)
    assert 60 - AHEAD_NS // MS <= len(bench.sent()) <= 60
    bench.clock.advance_to(1 * S)
    bench.end.send(b"x")
    assert bench.sent().endswith(b"x")


def test_client_is_held_while_much_is_waiting(bench: Bench) -> None:
    bench.end.send(bytes(MOST_WAITING + 100))
    assert bench.room == [False]
    bench.clock.advance_to(5 * S)
    assert bench.room == [False, True]
    assert len(bench.sent()) == MOST_WAITING + 100


def test_hold_keeps_bytes_back(bench: Bench) -> None:
    bench.end.hold(True)
    bench.end.send(b"ab")
    bench.clock.advance_to(S)
    assert bench.sent() == b""
    bench.end.hold(False)
    assert bench.sent() == b"ab"


def test_unpaced_end_keeps_nothing_back() -> None:
    bench = Bench(Format(50), is_paced=False)
    bench.end.send(bytes(10_000))
    assert len(bench.sent()) == 10_000


def test_slow_line_is_fed_character_by_character() -> None:
    bench = Bench(Format(50))
    bench.end.send(b"abc")
    bench.clock.advance_to(S)
    assert bench.link.take() == [b"a", b"b", b"c"]


def test_client_that_leaves_takes_lines_and_format_and_waiting_bytes_along(bench: Bench) -> None:
    bench.end.plug_in()
    bench.end.set_format(Format(300))
    bench.end.send(bytes(100))
    bench.link.take()
    bench.end.hang_up()
    bench.clock.advance_to(10 * S)
    assert bench.link.take() == [Format(10_000), ControlLines(dtr=False, rts=False)]


def test_what_does_not_change_is_not_said_again(bench: Bench) -> None:
    bench.end.set_dtr(True)
    bench.end.set_format(Format(10_000))
    assert bench.link.take() == []


@given(st.lists(st.tuples(st.binary(max_size=300), st.integers(0, 10**9)), max_size=20), st.integers(50, 10**7))
def test_every_byte_is_fed_once_in_order(pieces: list[tuple[bytes, int]], baud: int) -> None:
    bench = Bench(Format(baud))
    for data, pause_ns in pieces:
        bench.end.send(data)
        bench.clock.advance_to(bench.clock.now_ns() + pause_ns)
    bench.clock.advance_to(10**15)
    assert bench.sent() == b"".join(data for data, _ in pieces)
