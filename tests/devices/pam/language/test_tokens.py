"""Comments, numbers and signs of the language."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pam.language.tokens import LARGEST_INTEGER, split


@pytest.mark.parametrize(
    ("text", "value"),
    [("42", 42), ("#0FFE", 0x0FFE), ("#29", 41), ("1.5", 1.5), ("11930464.71111111", 11930464.71111111), ("7.", 7.0)],
)
def test_numbers(text: str, value: float) -> None:
    (number, end), mistakes = split(text, "a").tokens, split(text, "a").mistakes
    assert (number.value, end.kind, mistakes) == (value, "end", [])


def test_a_number_of_more_than_32_bits_is_a_mistake() -> None:
    found = split("4294967296", "a")
    assert found.tokens[0].value == LARGEST_INTEGER
    assert "more than 32 bits" in str(found.mistakes[0])


@pytest.mark.parametrize("comment", ["// to the end", "/** to the end", "/* a block */", "/**/", "/* of two\nlines */"])
def test_comments_are_set_aside(comment: str) -> None:
    found = split(f"a {comment}\nb", "x")
    assert [token.text for token in found.tokens] == ["a", "b", "the end of the text"]
    assert [text for _, text in found.comments] == [comment]
    assert found.mistakes == []


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("/* a /* b */ c */ d", 1),  # manual line 794
        ("/* a /* b /* c */ d */ e */ d", 1),
        ("/* a\n/* b\n*/ § IF 'c \n*/ d", 4),
    ],
)
def test_blocks_of_comments_do_not_nest(text: str, line: int) -> None:
    found = split(text, "x")
    assert [token.text for token in found.tokens] == ["d", "the end of the text"]
    assert [(wrong.line, wrong.hint) for wrong in found.mistakes] == [
        (line, "Comments do not nest: the one of line 1 ends at its first */.")
    ]


@pytest.mark.parametrize("text", ["a */ b", "// a /* b\n */ c", "/** a /* b\n */ c"])
def test_an_end_without_a_comment_is_a_mistake(text: str) -> None:
    assert [wrong.what for wrong in split(text, "x").mistakes] == ["*/ ends no comment"]


SIGNS = {
    "!=": "<>", "==": "=", ":=": "<-", "->": "<-", "=>": ">=", "=<": "<=", "&": "*", "&&": "*", "||": "+", "**": "^",
}  # fmt: skip


@pytest.mark.parametrize(("sign", "right"), SIGNS.items())
def test_signs_of_other_languages_name_the_right_one(sign: str, right: str) -> None:
    found = split(f"a {sign} b", "x")
    assert [token.text for token in found.tokens][:3] == ["a", right, "b"]
    assert [str(wrong) for wrong in found.mistakes] == [f"x:1:3: got {sign}; expected {right}"]


@pytest.mark.parametrize(
    ("text", "right"), [("ADDRESS := 5", "="), ("ADDRESS == 5", "="), ("AXI_a:TRAVEL_SPEED := 5", "<-")]
)
def test_a_parameter_has_the_sign_of_its_place(text: str, right: str) -> None:
    assert [wrong.expected for wrong in split(text, "x").mistakes] == [right]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("a /* b", "the comment has no end; expected */"),
        ('"abc', "the text has no end"),
        ("a[1]", "an index is wrong; expected [i], [all], [all+] or [all*]"),
        ("# 5", "# has no meaning here"),
        ("a @ b", "'@' has no meaning here"),
    ],
)
def test_what_is_no_token(text: str, said: str) -> None:
    assert said in str(split(text, "x").mistakes[0])


def test_places_and_lines() -> None:
    tokens = split("a\n  b <- c;", "x").tokens
    assert [(token.place.line, token.place.column) for token in tokens[:4]] == [(1, 1), (2, 3), (2, 5), (2, 8)]
    assert [token.begins_line for token in tokens[:3]] == [True, True, False]


@given(st.text(max_size=200))
def test_any_text_has_tokens(text: str) -> None:
    found = split(text, "x")
    assert found.tokens[-1].kind == "end"
    places = [(token.place.line, token.place.column) for token in found.tokens]
    assert places == sorted(places)
