"""Words of other languages, and words whose underscores are wrong or missing: what they are in that of the PAM.

A word that has one meaning is read as what it means, so that there is one message for it.  Names that the program
declares are left alone.
"""

from collections.abc import Container, Iterator, Sequence
from typing import Final

from fieldrig_devices.languages.mistakes import Mistake
from fieldrig_devices.pam.language.reserved import IN_CAPITALS, ITEMS, RESERVED
from fieldrig_devices.pam.language.tokens import Token, mistake
from fieldrig_devices.pam.language.words import STRUCTURE

_WITHOUT_UNDERSCORES: Final = {
    word.replace("_", "").upper(): word for word in (*sorted(RESERVED), *sorted(STRUCTURE)) if len(word) > 4
}
"""The reserved words by what is left of them without underscores; words of statements come before functions."""
_SIGNS: Final = {"AND": "*", "OR": "+", "NOT": "!", "MOD": "%", "DIV": "/"}
_FLAGS: Final = {"TRUE": 1, "FALSE": 0}
_NAMED: Final = ("NAME", "FILE")
"""Parameters whose values are names."""


def corrected(tokens: Sequence[Token], names: Container[str], mistakes: list[Mistake]) -> list[Token]:
    """Return the tokens of a program in its own words, and add a message for each that was none."""
    return list(_corrected(_joined(tokens, names, mistakes), names, mistakes))


def _joined(tokens: Sequence[Token], names: Container[str], mistakes: list[Mistake]) -> list[Token]:
    """Return the tokens with one word in the place of two that should have an underscore, such as END IF."""
    joined: list[Token] = []
    for token in tokens:
        before = joined[-1] if joined else token
        word = f"{before.text}_{token.text}".upper()
        if word in STRUCTURE and before.kind == token.kind == "name" and not _is_apart(before, token, names):
            mistakes.append(mistake(before.place, f"got {before.text} {token.text}", word))
            joined[-1] = Token("name", word, before.place, 0, before.begins_line)
        else:
            joined.append(token)
    return joined


def _is_apart(first: Token, second: Token, names: Container[str]) -> bool:
    """True for two words that stand for themselves: END may be followed by TASK, and names by words."""
    is_item = first.text.upper() == "END" and second.text.upper() in ITEMS
    return is_item or second.begins_line or first.text in names or second.text in names


def _corrected(tokens: Sequence[Token], names: Container[str], mistakes: list[Mistake]) -> Iterator[Token]:
    for at, token in enumerate(tokens):
        is_value_of_name = at > 1 and tokens[at - 1].text == "=" and tokens[at - 2].text.upper() in _NAMED
        right = None if token.kind != "name" or token.text in names or is_value_of_name else _right(token)
        if right is not None:
            mistakes.append(mistake(token.place, f"got {token.text}", right.text))
        yield token if right is None else right


def _right(token: Token) -> Token | None:
    """Return what a token means; None for a name, and for a word that is right."""
    word = token.text.upper()
    if word in IN_CAPITALS:
        return None
    if word in _SIGNS:
        return Token("sign", _SIGNS[word], token.place, 0, token.begins_line)
    if word in _FLAGS:
        return Token("integer", str(_FLAGS[word]), token.place, _FLAGS[word], token.begins_line)
    meant = _WITHOUT_UNDERSCORES.get(word.replace("_", ""))
    return None if meant is None else Token("name", meant, token.place, 0, token.begins_line)
