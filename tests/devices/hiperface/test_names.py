"""Telegrams of a HIPERFACE line in words; the telegrams are those that the sources of `telegram.py` print."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.hiperface.names import LONGEST, HiperfaceReader


@pytest.mark.parametrize(
    ("asked", "kind", "answered", "text"),
    [
        ("40 42 02", "READ POSITION", "40 42 00 00 a0 00 a2", "position 40960"),
        ("40 50 10", "READ STATUS", "40 50 00 10", "00h no error"),
        ("40 52 12", "TYPE LABEL", "40 52 e4 27 80 00 51", "E4 27 80 00"),
        ("40 46 06", "READ COUNTER", "40 46 00 00 00 06", "00 00 00"),
    ],
)
def test_a_command_and_its_answer_have_a_name(asked: str, kind: str, answered: str, text: str) -> None:
    reader = HiperfaceReader("encoder")
    assert reader("drive", bytes.fromhex(asked)) == [(kind, "encoder 40h")]
    assert reader("encoder", bytes.fromhex(answered)[:1]) == []
    assert reader("encoder", bytes.fromhex(answered)[1:]) == [(f"{kind} answer", f"encoder 40h, {text}")]


def test_bit_7_of_the_command_says_that_status_messages_wait() -> None:
    reader = HiperfaceReader("encoder")
    text = "encoder 40h, 00 00 00, status messages wait"
    assert reader("encoder", bytes.fromhex("40 c6 00 00 00 86")) == [("READ COUNTER answer", text)]


def test_a_damaged_telegram_ends_with_the_next_talker() -> None:
    reader = HiperfaceReader("encoder")
    assert reader("drive", bytes.fromhex("40 42 03")) == [("wrong checksum", "40 42 03")]
    assert reader("drive", bytes.fromhex("40 01")) == [("no telegram", "40 01")]
    assert reader("drive", b"\x40") == []
    assert reader("encoder", bytes.fromhex("40 50 04 14"))[0][1].endswith("04h analog limits not available")


@given(st.lists(st.tuples(st.sampled_from(["drive", "encoder"]), st.binary(max_size=40)), max_size=12))
def test_any_bytes_have_some_words_in_constant_memory(sent: list[tuple[str, bytes]]) -> None:
    reader = HiperfaceReader("encoder")
    for sender, data in sent:
        assert all(kind for kind, _ in reader(sender, data))
        assert len(reader._open) <= LONGEST
