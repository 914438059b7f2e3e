"""WSTRING of edition 3: constants, functions, conversions, and its characters of 16 bits in memory."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from iec_program import IecBench, program, refused

from fieldrig_devices.iec import characters, literal_texts, literals
from fieldrig_devices.iec.dialect import EDITION_3, EPAS_4
from fieldrig_devices.iec.elementary import Elementary
from fieldrig_devices.iec.library.conversions import convert
from fieldrig_devices.iec.types import StringType

WIDE, NARROW = StringType(is_wide=True), StringType()
OF_16_BITS = st.text(st.characters(max_codepoint=0xFFFF, exclude_categories=["Cs"]), max_size=40)
DECLARATIONS = """
    text : WSTRING := "Grüße";
    euro : WSTRING(2) := "$20AC$"";
    short : WSTRING(3);
    list : ARRAY[1..2] OF WSTRING(4) := ["ab", "cd"];
    back : STRING;
    length, place, size, code : INT;
    value : REAL;
    shown, joined, next : WSTRING;
    is_less, is_equal : BOOL;
    word_at : POINTER TO WORD;
    cell : POINTER TO WSTRING;
"""
BODY = """
    short := text;
    length := LEN(text);
    place := FIND(text, "ß");
    size := SIZEOF(text) + 1000 * SIZEOF(short);
    word_at := ADR(euro);
    code := WORD_TO_INT(word_at^ AND 16#FFFF);
    back := WSTRING_TO_STRING(CONCAT(text, euro));
    value := WSTRING_TO_REAL("2.5");
    shown := DINT_TO_WSTRING(-70000);
    joined := CONCAT(MID(text, 2, 4), STRING_TO_WSTRING('-'), WSTRING#"x");
    is_less := text < "Grüßf";
    is_equal := RIGHT(text, 2) = "ße";
    cell := ADR(list[2]);
    next := cell^;
"""


@pytest.fixture(scope="module")
def bench() -> IecBench:
    bench = IecBench(program(DECLARATIONS, BODY), EDITION_3)
    bench.cycle()
    return bench


@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("text", "Grüße"),
        ("euro", '€"'),
        ("short", "Grü"),
        ("length", 5),
        ("place", 4),
        ("size", 162 + 8000),
        ("code", 0x20AC),
        ("back", 'Grüße?"'),
        ("value", 2.5),
        ("shown", "-70000"),
        ("joined", "ße-x"),
        ("is_less", True),
        ("is_equal", True),
        ("next", "cd"),
    ],
)
def test_texts_of_16_bits(bench: IecBench, name: str, value: object) -> None:
    assert bench[name] == value


@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("w := 'a';", "use STRING_TO_WSTRING('a')"),
        ("s := w;", "w is a WSTRING; expected STRING"),
        ("b := w = s;", "= between WSTRING and STRING"),
        ("s := CONCAT(s, w);", "CONCAT with STRING, WSTRING"),
        ('w := "$2G";', "$2 means nothing in a string"),
        ('w := "$D83D";', "does not have 16 bits"),
        ('w := "\U0001f600";', "does not have 16 bits"),
        ('w := "open;', 'got "'),
        ("w := 5;", 'write "5" for text'),
    ],
)
def test_kinds_of_texts_do_not_mix(statement: str, expected: str) -> None:
    found = refused(program("w : WSTRING; s : STRING; b : BOOL;", statement), EDITION_3)
    assert any(expected in message for message in found), found


def test_the_controller_does_not_have_them() -> None:
    assert any(
        "the type WSTRING is not declared" in message for message in refused(program("w : WSTRING;", ""), EPAS_4)
    )
    assert any("single quotes" in message for message in refused(program("s : STRING;", 's := "a";'), EPAS_4))


@given(OF_16_BITS)
def test_a_constant_gives_the_text_back(text: str) -> None:
    assert literals.wide_string(literal_texts.wide_string_text(text)) == text


@given(st.text(st.characters(max_codepoint=0xFF), max_size=80))
def test_a_string_comes_back_from_a_wide_one(text: str) -> None:
    assert convert(convert(text, NARROW, WIDE), WIDE, NARROW) == text


@given(OF_16_BITS)
def test_a_wide_string_becomes_latin_1(text: str) -> None:
    assert convert(text, WIDE, NARROW) == text.encode("latin-1", "replace").decode("latin-1")


@pytest.mark.parametrize("kind", Elementary)
@given(text=OF_16_BITS | st.integers().map(str) | st.from_regex(r"(T|D|DT|TOD)#[0-9dhms:.-]+", fullmatch=True))
def test_both_kinds_of_text_are_read_alike(kind: Elementary, text: str) -> None:
    narrow = text.encode("latin-1", "replace").decode("latin-1")[:80]
    wide = narrow if kind is Elementary.WCHAR else text[:80]
    assert repr(convert(wide, WIDE, kind)) == repr(convert(narrow, NARROW, kind))


@given(st.binary(max_size=40))
def test_any_memory_is_a_text(data: bytes) -> None:
    text = characters.decoded(data, is_wide=True)
    assert characters.first_outside(text, is_wide=True) is None
    assert 2 * len(text) <= len(data)


@given(OF_16_BITS.filter(lambda text: "\0" not in text))
def test_memory_gives_the_text_back(text: str) -> None:
    assert characters.decoded(characters.encoded(text, is_wide=True) + b"\0\0", is_wide=True) == text
