"""The start and end of a telegram, the effect of a damaged one, and the times of answers."""

import pytest
from hiperface_bench import EncoderBench, telegram
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_devices.hiperface.encoder import DELAYS_NS, QUERY_NS
from fieldrig_devices.hiperface.telegram import REQUEST_DATA, longest_ns

READ_POSITION = bytes.fromhex("40 42 02")


def in_characters(bench: EncoderBench, data: bytes, apart_ms: float = 1.2) -> None:
    for octet in data:
        bench.wait(apart_ms)
        bench.send(bytes((octet,)))


def test_telegram_may_come_byte_by_byte() -> None:
    bench = EncoderBench()
    in_characters(bench, READ_POSITION)
    assert bench.heard() == telegram("42 00 00 00 00")


def test_wrong_checksum_is_told() -> None:
    bench = EncoderBench()
    bench.send(bytes.fromhex("40 42 03"))
    assert bench.heard() == telegram("50 0a")


def test_broken_telegram_is_told_when_the_line_is_silent() -> None:
    bench = EncoderBench()
    in_characters(bench, telegram("4a 00 00 06 55")[:-1])
    assert bench.heard() == telegram("50 0c")
    bench.wait(10)
    bench.send(b"\x40")
    assert bench.heard() == b""  # an address alone asks for nothing


def test_unknown_command_is_told_when_the_line_is_silent() -> None:
    bench = EncoderBench()
    in_characters(bench, telegram("60 01 02"))
    assert bench.heard(19) == b""
    assert bench.heard(20) == telegram("50 0b")


def test_what_is_for_others_is_not_heard_up_to_a_silence() -> None:
    bench = EncoderBench()
    bench.wait(10)
    in_characters(bench, telegram("42", 0x41) + READ_POSITION)
    assert bench.heard() == b""
    bench.wait(6)
    in_characters(bench, READ_POSITION)
    assert bench.heard() == telegram("42 00 00 00 00")


def test_what_comes_during_an_answer_is_lost() -> None:
    bench = EncoderBench()
    bench.send(telegram("47"))
    bench.wait(1)
    bench.send(READ_POSITION)
    assert bench.heard() == telegram("47")
    assert bench.heard() == b""


def test_answers_come_within_the_time_that_drives_wait() -> None:
    for command in REQUEST_DATA:
        assert DELAYS_NS.get(command, QUERY_NS) < longest_ns(command)
    bench = EncoderBench()
    before_ns = bench.clock.now_ns()
    bench.send(READ_POSITION)
    bench.heard()
    assert bench.clock.now_ns() - before_ns == 1 * MS


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.binary(min_size=1, max_size=12), st.integers(0, 40)), max_size=12))
def test_garbage_never_raises_and_never_deafens(noise: list[tuple[bytes, int]]) -> None:
    bench = EncoderBench()
    for data, wait_ms in noise:
        bench.send(data)
        bench.heard(wait_ms)
    bench.heard(1000)
    bench.wait(200)
    bench.send(telegram("50", 0xFF))
    assert bench.heard()[1] & 0x7F == 0x50


@pytest.mark.long
@settings(max_examples=150, deadline=None)
@given(st.sampled_from(sorted(REQUEST_DATA)), st.binary(max_size=20))
def test_any_data_of_any_command_get_an_answer(command: int, data: bytes) -> None:
    bench = EncoderBench()
    answer = bench.ask(bytes((command,)).hex() + data.hex())
    is_reset = command == 0x53 and data[:1] in (b"", b"\x13")
    assert (answer == "") == is_reset
