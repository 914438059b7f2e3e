"""The text of a source file, from the bytes that tools write."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.languages import source_file
from fieldrig_devices.languages.source_file import decoded


@pytest.mark.parametrize(
    "data",
    [
        "28 2a 20 c3 9c 20 2a 29",  # UTF-8
        "ef bb bf 28 2a 20 c3 9c 20 2a 29",  # with a mark
        "ff fe 28 00 2a 00 20 00 dc 00 20 00 2a 00 29 00",  # UTF-16, low byte first
        "fe ff 00 28 00 2a 00 20 00 dc 00 20 00 2a 00 29",  # high byte first
        "28 2a 20 dc 20 2a 29",  # the code page 1252 of Windows
    ],
)
def test_every_encoding_of_the_tools_gives_the_same_text(data: str) -> None:
    assert decoded(bytes.fromhex(data)) == "(* Ü *)"


def test_a_dash_of_windows_is_a_dash() -> None:
    assert decoded(b"(* 1\x965 \xfc *)") == "(* 1\N{EN DASH}5 ü *)"


@given(st.binary(max_size=40))
def test_no_bytes_are_refused(data: bytes) -> None:
    assert len(decoded(data)) <= len(data)


def test_a_file_that_is_too_long_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(source_file, "LONGEST", 4)
    assert decoded(b"abcd") == "abcd"
    with pytest.raises(ValueError, match="5 bytes are too long for a source file: expected at most 4"):
        decoded(b"abcde")


@pytest.mark.parametrize(
    "data",
    [
        "48 94 68 65 3a 20 81 62 65 72 20 4e 75 6c 6c 2c 20 99 6c 20 61 75 66 66 81 6c 6c 65 6e",  # 850 of DOS
        "48 f6 68 65 3a 20 fc 62 65 72 20 4e 75 6c 6c 2c 20 d6 6c 20 61 75 66 66 fc 6c 6c 65 6e",  # 1252 of Windows
    ],
)
def test_letters_of_dos_and_of_windows_are_told_apart_by_words(data: str) -> None:
    assert decoded(bytes.fromhex(data)) == "Höhe: über Null, Öl auffüllen"


def test_quotes_of_windows_are_no_letters_of_dos() -> None:
    text = b"(* the \x93first\x94 axis doesn\x92t move, \x84so\x94, 1\x965 \xfcber *)"
    assert decoded(text) == "(* the “first” axis doesn’t move, „so”, 1–5 über *)"


@pytest.mark.parametrize("end", [b"\x1a", b"\r\n\x1a", b"\x1a\x1a\x1a\0\0", b"\n\x1a\r\n", "\x1a".encode("utf-16")[2:]])
def test_the_end_of_a_text_of_dos_is_no_part_of_it(end: bytes) -> None:
    head = "x := 1;".encode("utf-16") if len(end) == 2 and end[1] == 0 else b"x := 1;"
    assert decoded(head + end) == "x := 1;\n"


def test_what_is_behind_the_end_of_a_text_is_not_lost() -> None:
    assert decoded(b"x := 1;\n\x1a\ny := 2;\n") == "x := 1;\n\x1a\ny := 2;\n"
