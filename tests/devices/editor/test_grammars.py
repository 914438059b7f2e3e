"""The colours of the three languages, against the tokens that our compilers make of the same texts."""

from pathlib import Path
from typing import Any, Final

import pytest
from hypothesis import given
from hypothesis import strategies as st
from textmate import pieces

from fieldrig.text.source_text import decoded
from fieldrig_devices.arp.language import instructions
from fieldrig_devices.arp.language import tokens as arp_tokens
from fieldrig_devices.editor.grammars import GRAMMARS, iec
from fieldrig_devices.iec.dialect import CODESYS, DIALECTS
from fieldrig_devices.iec.tokens import INTEGER, REAL, STRING, keywords, tokens
from fieldrig_devices.pam.language.reserved import RESERVED
from fieldrig_devices.pam.language.tokens import split

ROOT = Path(__file__).parents[3]
MADE: Final = {language: grammar() for language, grammar in GRAMMARS.items()}
PROGRAMS: Final = ROOT / "configs/programs"
LIBRARIES: Final = ROOT / "devices/fieldrig_devices/iec/library"
NAMES: Final = ("variable", "entity", "support.type")
"""The scopes of what our compilers take as names; types are names to them."""
IS_WORD: Final = ("keyword.control", "keyword.operator.word", "storage", "constant.language")


class Colours:
    """The colours of a text by the places where pieces begin."""

    def __init__(self, language: str, text: str) -> None:
        self._scopes = {(one.line, one.column): one.scope for one in pieces(MADE[language], text)}

    def at(self, line: int, column: int) -> str:
        """Return the scope of the piece that begins at a place; nothing if none does."""
        return self._scopes.get((line, column), "")


def texts(*patterns: str) -> list[Path]:
    files = [file for pattern in patterns for file in sorted(ROOT.glob(pattern))]
    assert files
    return files


@pytest.mark.parametrize(
    "file", texts("configs/**/*.st", "devices/fieldrig_devices/iec/library/*.st"), ids=lambda p: p.name
)
def test_structured_text_has_the_colours_of_its_tokens(file: Path) -> None:
    text = decoded(file.read_bytes())
    colours, read, known = Colours("st", text), tokens(text, file.name, CODESYS), keywords(CODESYS)
    for kind, word, (line, column) in zip(read.kinds, read.texts, read.positions, strict=True):
        scope = colours.at(line, column)
        if kind in known:
            assert scope.startswith(IS_WORD), (word, line, scope)
        elif kind == "name":
            assert not is_wrong_name(scope, word), (word, line, scope)
        elif kind in (INTEGER, REAL):
            assert scope.startswith("constant.numeric"), (word, line, scope)
        elif kind == STRING:
            assert scope.startswith("string"), (word, line, scope)


def is_wrong_name(scope: str, word: str) -> bool:
    """A keyword of another dialect, or at its place only, may look like one."""
    others = {each for dialect in DIALECTS.values() for each in keywords(dialect)}
    is_other = word.upper() in others or scope == "storage.type.placed.st"
    return not scope.startswith(NAMES) and not is_other


@pytest.mark.parametrize("dialect", DIALECTS.values(), ids=DIALECTS)
def test_every_keyword_of_every_dialect_has_a_colour(dialect: Any) -> None:
    for word in sorted(keywords(dialect)):
        for spelling in (word, word.lower(), word.capitalize()):
            (piece,) = pieces(MADE["st"], spelling)
            assert (piece.text, piece.scope.startswith(IS_WORD)) == (spelling, True)


@pytest.mark.parametrize("kind", sorted(iec.TYPES))
def test_types_have_a_colour_of_their_own(kind: str) -> None:
    assert [piece.scope for piece in pieces(MADE["st"], kind)] == ["support.type.st"]


@pytest.mark.parametrize(
    ("text", "colours"),
    [
        ("step := test;", ["variable.other.st", "keyword.operator.st", "variable.other.st"]),
        ("TEST 'a'", ["storage.type.placed.st", "string.quoted.single.st"]),
        ("END_TEST", ["storage.type.placed.st"]),
        ("T#1h2m3.5s", ["constant.numeric.typed.st"]),
        ("16#FF 1_000 2.5E-3", ["constant.numeric.st"] * 3),
        ("INT#16#7F Colour#red", ["constant.numeric.typed.st"] * 2),
        ("DT#1998-02-13-14:20", ["constant.numeric.typed.st"]),
        ("%QX1.0 %MW* %I4", ["constant.other.address.st"] * 3),
        ("'it$'s' \"wide\"", ["string.quoted.single.st", "string.quoted.double.st"]),
        ("(* IF (* a *) b *) x", ["comment.block.st", "variable.other.st"]),
        ("x // IF", ["variable.other.st", "comment.line.double-slash.st"]),
        ("{attribute 'a'}", ["meta.preprocessor.st"]),
        ("Twice (3)", ["entity.name.function.st", "constant.numeric.st"]),
        ("IFs ENDIF_ xIF", ["variable.other.st"] * 3),
    ],
)
def test_pieces_of_structured_text(text: str, colours: list[str]) -> None:
    assert [piece.scope for piece in pieces(MADE["st"], text)] == colours


def test_a_comment_goes_over_lines() -> None:
    found = list(pieces(MADE["st"], "a (* IF\nTHEN\n*) b"))
    assert [(piece.line, piece.text) for piece in found if "comment" in piece.scope] == [
        (1, "(* IF"),
        (2, "THEN"),
        (3, "*)"),
    ]


def test_an_application_of_the_pam_has_the_colours_of_its_tokens() -> None:
    text = decoded((PROGRAMS / "labeller.pam").read_bytes())
    colours = Colours("pam", text)
    for token in split(text, "labeller.pam").tokens:
        scope = colours.at(token.place.line, token.place.column)
        if token.kind == "name":
            is_reserved = token.text in RESERVED
            assert is_reserved == (not scope.startswith(("variable", "support.variable"))), token
        elif token.kind in ("integer", "real"):
            assert scope.startswith("constant.numeric"), token
        elif token.kind == "text":
            assert scope.startswith("string"), token


def test_every_word_of_the_pam_has_a_colour() -> None:
    for word in sorted(RESERVED):
        for spelling in (word, word.upper(), word.lower()):
            assert [piece.scope.startswith("variable") for piece in pieces(MADE["pam"], spelling)] == [False]


@pytest.mark.parametrize("file", texts("configs/programs/*.I0*"), ids=lambda path: path.name)
def test_programs_of_arp_cards_have_the_colours_of_their_tokens(file: Path) -> None:
    text = decoded(file.read_bytes())
    colours = Colours("arp", text)
    for number, line in enumerate(text.split("\n"), 1):
        for token in arp_tokens.tokens(line):
            scope = colours.at(number, token.column)
            match token.kind:
                case arp_tokens.Kind.WORD:
                    is_keyword = scope.startswith(("keyword", "constant", "support.function"))
                    assert is_keyword == is_word_of_arp(token.text), (token, scope)
                case arp_tokens.Kind.NUMBER:
                    assert scope.startswith("constant.numeric"), (token, scope)
                case arp_tokens.Kind.STRING:
                    assert scope.startswith("string"), (token, scope)
                case arp_tokens.Kind.SYSTEM:
                    assert scope.startswith("support.variable.system"), (token, scope)


def is_word_of_arp(word: str) -> bool:
    return word in instructions.KEYWORDS or (word[:-1] in ("ON", "CAM") and word[-1].isdigit())


def test_every_word_of_arp_has_a_colour() -> None:
    for word in sorted(instructions.KEYWORDS - {"CAM"}):
        assert [piece.scope.startswith("variable") for piece in pieces(MADE["arp"], word.lower())] == [False]


@given(st.sampled_from(sorted(GRAMMARS)), st.text(max_size=40))
def test_any_text_is_coloured_once_and_in_order(language: str, text: str) -> None:
    found = list(pieces(MADE[language], text))
    ends = [(piece.line, piece.column + len(piece.text)) for piece in found]
    starts = [(piece.line, piece.column) for piece in found]
    assert all(end <= start for end, start in zip(ends, starts[1:], strict=False))
