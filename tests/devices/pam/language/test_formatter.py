"""The layout of texts, wrong ones as well: no text gets other tokens, and a second time changes nothing."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_devices.pam.language.formatter import formatted, strangers
from fieldrig_devices.pam.language.tokens import split

WORDS = [
    "NODE",
    "AXIS",
    "IF",
    "THEN",
    "END_IF",
    "END",
    "INTERNAL",
    "FLAG_VAR",
    "x",
    "H",
    "ms",
    "e3",
    '"a  b"',
    "[all+]",
]
NUMBERS = ["5", "101", "1.5", "0.", "101.", "#FF"]
SIGNS = [*";.=+-*<>?()!:,|/%^", "<-", "<>", "<<", "// c", "/* d */", "\\\n", "\n"]
PIECE = st.tuples(st.sampled_from([*WORDS, *NUMBERS, *SIGNS]), st.sampled_from(["", " ", "\n", "\t"]))


@given(st.lists(PIECE, max_size=14))
def test_no_text_gets_other_tokens_and_a_second_time_changes_nothing(parts: list[tuple[str, str]]) -> None:
    text = "".join(f"{word}{blank}" for word, blank in parts)
    if strangers(text, ""):
        return
    once = formatted(text)
    assert formatted(once) == once
    assert _tokens(once) == _tokens(text)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("x;101 . =101", "x ; 101 . = 101\n"),
        ("IF ! =x", "IF ! = x\n"),
        ("x; : = 5", "x ; : = 5\n"),
        ("x; . 5", "x ; . 5\n"),
        ("x<-5+  y;", "x <- 5 + y;\n"),
    ],
)
def test_tokens_that_would_become_others_stay_apart(text: str, expected: str) -> None:
    assert formatted(text) == expected


def _tokens(text: str) -> list[tuple[str, str]]:
    return [(token.kind, token.text) for token in split(text, "").tokens]
