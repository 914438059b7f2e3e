"""The text of a source file, from the bytes that tools write."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.text import source_text
from fieldrig.text.source_text import decoded


@pytest.mark.parametrize(
    "data",
    [
        "28 2a 20 c3 9c 20 2a 29",  # UTF-8
        "ef bb bf 28 2a 20 c3 9c 20 2a 29",  # with a mark
        "ff fe 28 00 2a 00 20 00 dc 00 20 00 2a 00 29 00",  # UTF-16, low byte first
        "fe ff 00 28 00 2a 00 20 00 dc 00 20 00 2a 00 29",  # high byte first
        "28 00 2a 00 20 00 dc 00 20 00 2a 00 29 00",  # UTF-16 without a mark
        "00 28 00 2a 00 20 00 dc 00 20 00 2a 00 29",
        "28 2a 20 dc 20 2a 29",  # the code page 1252 of Windows
    ],
)
def test_every_encoding_of_the_tools_gives_the_same_text(data: str) -> None:
    assert decoded(bytes.fromhex(data)) == "(* Ü *)"


def test_a_dash_of_windows_is_a_dash() -> None:
    assert decoded(b"(* 1\x965 \xfc *)") == "(* 1\N{EN DASH}5 ü *)"


@pytest.mark.parametrize("encoding", ["utf-16-le", "utf-16-be"])
@given(st.text(st.characters(max_codepoint=0x7F, exclude_characters="\x1a\r\0"), min_size=1, max_size=60))
def test_a_program_in_utf_16_needs_no_mark(encoding: str, text: str) -> None:
    assert decoded(text.encode(encoding)) == text


@given(st.text(st.characters(min_codepoint=0x20, max_codepoint=0x7E), max_size=60), st.integers(0, 9))
def test_zeros_behind_a_text_are_no_characters(text: str, zeros: int) -> None:
    assert decoded(text.encode() + bytes(zeros)) == text


@given(st.binary(max_size=40))
def test_no_bytes_are_refused(data: bytes) -> None:
    assert len(decoded(data)) <= len(data)


def test_a_file_that_is_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_text, "LONGEST", 4)
    assert decoded(b"abcd") == "abcd"
    with pytest.raises(ValueError, match="5 bytes are too long for a source file: expected at most 4"):
        decoded(b"abcde")
