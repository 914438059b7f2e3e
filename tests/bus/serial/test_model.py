"""Characters on a serial line take the time of their format."""

import itertools
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS, S
from fieldrig_bus.serial.message import Break, ControlLines, Format, SerialMessage
from fieldrig_bus.serial.model import SerialModel

EVERYTHING = ("data", "lines", "format", "break")
AT_1000_BAUD = Format(1000)  # 8N1: a character takes 10 ms


def line(*members: str, form: Format = AT_1000_BAUD, interest: Any = EVERYTHING, **more: Any) -> SerialModel:
    model = SerialModel(form, **more)
    for member in members:
        model.join(member)
        model.listen(0, member, interest)
    return model


def heard(model: SerialModel, until_ns: int = 1000 * S) -> list[tuple[int, str, SerialMessage, tuple[str, ...]]]:
    return [(time, sender, message, tuple(to)) for time, sender, message, to in model.collect(until_ns)]


def test_character_arrives_when_its_last_bit_has() -> None:
    model = line("a", "b")
    model.submit(5 * MS, "a", b"x")
    assert model.next_ns() == 15 * MS
    assert model.collect(15 * MS - 1) == []
    assert heard(model) == [(15 * MS, "a", b"x", ("b",))]


@pytest.mark.parametrize(
    ("form", "nanoseconds"),
    [  # start bit, data bits, parity bit, stop bits
        (Format(1000, 8, "N", 1), 10 * MS),
        (Format(1000, 8, "E", 1), 11 * MS),
        (Format(1000, 7, "O", 2), 11 * MS),
        (Format(1000, 5, "N", 1), 7 * MS),
        (Format(115200, 8, "N", 1), 86_805),
    ],
)
def test_character_takes_its_bits_by_the_baud_rate(form: Format, nanoseconds: int) -> None:
    model = line("a", "b", form=form)
    model.submit(0, "a", b"x")
    assert model.next_ns() == nanoseconds


def test_bytes_arrive_in_chunks_over_time() -> None:
    model = line("a", "b", chunk_ns=25 * MS)
    model.submit(0, "a", b"abcde")
    assert [(time, data) for time, _, data, _ in heard(model)] == [(20 * MS, b"ab"), (40 * MS, b"cd"), (50 * MS, b"e")]


def test_transmitter_sends_one_thing_after_the_other() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"x")
    model.submit(1 * MS, "a", Break(30))
    model.submit(2 * MS, "a", b"y")
    assert [(time, message) for time, _, message, _ in heard(model)] == [
        (10 * MS, b"x"),
        (40 * MS, Break(30)),
        (50 * MS, b"y"),
    ]


def test_both_directions_at_once() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"x")
    model.submit(0, "b", b"y")
    assert heard(model) == [(10 * MS, "a", b"x", ("b",)), (10 * MS, "b", b"y", ("a",))]


def test_format_holds_for_what_follows_it() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"x")
    model.submit(0, "a", Format(10_000))
    model.submit(0, "a", b"y")
    assert [(time, message) for time, _, message, _ in heard(model)] == [
        (0, Format(10_000)),
        (10 * MS, b"x"),
        (11 * MS, b"y"),
    ]


def test_control_lines_overtake_bytes() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"x")
    model.submit(1 * MS, "a", ControlLines(dtr=False))
    assert [(time, message) for time, _, message, _ in heard(model)] == [(MS, ControlLines(dtr=False)), (10 * MS, b"x")]


def test_without_interest_only_bytes_are_heard() -> None:
    model = line("a", "b", interest=None)
    for message in (ControlLines(), Format(), Break(1), b"x"):
        model.submit(0, "a", message)
    assert [message for _, _, message, to in heard(model) if to] == [b"x"]


def test_an_end_that_does_not_listen_gets_nothing() -> None:
    model = SerialModel(AT_1000_BAUD)
    model.join("a")
    model.join("b")
    model.submit(0, "a", b"x")
    assert heard(model) == [(10 * MS, "a", b"x", ())]


def test_interest_in_something_else_is_refused() -> None:
    with pytest.raises(ValueError, match="on a serial line: expected one of"):
        line("a").listen(0, "a", ["modem"])


def test_late_listener_hears_the_present_lines_and_format_only() -> None:
    model = line("a")
    for message in (ControlLines(dtr=False), ControlLines(rts=False), Format(300), b"x"):
        model.submit(0, "a", message)
    model.collect(S)
    model.join("b")
    model.listen(2 * S, "b", EVERYTHING)
    assert heard(model) == [(2 * S, "a", ControlLines(rts=False), ("b",)), (2 * S, "a", Format(300), ("b",))]


def test_an_end_that_set_nothing_is_not_reported() -> None:
    model = line("a", "b")
    assert model.next_ns() is None


def test_on_a_party_line_everyone_hears_everyone_else() -> None:
    model = line("a", "b", "c")
    model.submit(0, "b", b"x")
    assert heard(model) == [(10 * MS, "b", b"x", ("a", "c"))]


def test_what_a_member_had_not_sent_leaves_with_it() -> None:
    model = line("a", "b", chunk_ns=1)
    model.submit(0, "a", b"xyz")
    model.collect(10 * MS)
    model.leave("a")
    assert model.next_ns() is None
    model.submit(0, "b", b"z")
    assert heard(model) == [(10 * MS, "b", b"z", ())]


def test_late_word_never_arrives_before_what_was_heard() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"x")
    model.collect(10 * MS)
    model.submit(1 * MS, "b", ControlLines(dtr=False))
    assert model.next_ns() == 10 * MS


def test_unpaced_line_takes_no_time() -> None:
    model = line("a", "b", is_paced=False)
    model.submit(7, "a", b"x" * 1000)
    model.submit(7, "a", Break(100))
    assert [(time, message) for time, _, message, _ in heard(model)] == [(7, b"x" * 1000), (7, Break(100))]


def test_nothing_is_no_message() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"")
    assert model.next_ns() is None


def test_counts_what_was_sent() -> None:
    model = line("a", "b")
    model.submit(0, "a", b"xyz")
    model.submit(0, "b", Break(1))
    assert model.statistics(0) == {"characters": 3.0, "breaks": 1.0}


@given(
    st.lists(st.tuples(st.integers(0, 10**9), st.sampled_from("abc"), st.binary(max_size=40)), max_size=30),
    st.integers(50, 1_000_000),
    st.integers(1, 10**9),
)
def test_every_byte_arrives_once_in_order_and_not_faster_than_the_line(
    sent: list[tuple[int, str, bytes]], baud: int, chunk_ns: int
) -> None:
    model = line("a", "b", "c", form=Format(baud), chunk_ns=chunk_ns)
    for time, sender, data in sent:
        model.submit(time, sender, data)
    arrived = heard(model, 10**15)
    assert model.next_ns() is None
    assert [time for time, *_ in arrived] == sorted(time for time, *_ in arrived)
    for member in "abc":
        mine = [(time, message) for time, sender, message, _ in arrived if sender == member]
        assert b"".join(bytes(data) for _, data in mine if isinstance(data, bytes)) == b"".join(
            data for _, sender, data in sent if sender == member
        )
        for (before, _), (time, chunk) in itertools.pairwise(mine):
            assert isinstance(chunk, bytes)
            assert time - before >= len(chunk) * 10 * S // baud - 1


def test_garbling_line_gives_garbage_to_an_end_in_another_format() -> None:
    model = line("a", "b", "c", is_garbling=True)
    model.submit(0, "b", Format(2000))
    model.submit(0, "a", b"\x55")
    receivers = {to: message for _, _, message, to in heard(model) if isinstance(message, bytes)}
    assert receivers[("c",)] == b"\x55"
    assert receivers[("b",)] != b"\x55"


def test_what_an_end_had_sent_is_heard_in_the_format_of_then() -> None:
    model = line("a", "b", is_garbling=True)
    model.submit(0, "a", b"\x55")
    model.submit(0, "a", Format(2000))  # as the byte waits to be sent
    assert heard(model)[-1] == (10 * MS, "a", b"\x55", ("b",))


def test_what_an_end_has_received_is_not_garbled_by_its_later_format_on_a_late_host() -> None:
    in_time, late = (line("a", "b", is_garbling=True) for _ in range(2))
    for model in (in_time, late):
        model.submit(0, "a", b"\x55\x55")
    before = heard(in_time, 10 * MS)
    for model in (in_time, late):
        model.submit(15 * MS, "b", Format(2000))
    assert late.next_ns() == 10 * MS
    assert heard(late) == before + heard(in_time)
