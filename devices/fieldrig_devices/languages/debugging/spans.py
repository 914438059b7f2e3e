"""Statements that go over several lines: a breakpoint on any of their lines belongs to the line where they begin."""

from collections.abc import Collection, Sequence
from typing import Final

Token = tuple[str, int]
"""A symbol, or a word in capitals, and its line."""

_BRACKETS: Final = {"(": 1, "[": 1, ")": -1, "]": -1}


def goes_on(tokens: Sequence[Token], last: int, ends: Collection[str]) -> bool:
    """Return True if the statement of the first line of some tokens goes on in line `last`.

    `ends` are what a statement, or the head of a compound one, ends with, and the words that close a block.  A line
    without a token, such as a comment, belongs to the statement only if it is between brackets.
    """
    before = [token for token in tokens if token[1] < last]
    there = [text for text, line in tokens if line == last]
    ends_at = [number for number, (text, _) in enumerate(before) if text in ends]
    statement = before[ends_at[-1] + 1 if ends_at else 0 :]
    if not statement or statement[0][1] != tokens[0][1]:
        return False
    depth = sum(_BRACKETS.get(text, 0) for text, _ in statement)
    is_closing = bool(there) and there[0] in ends and there[0].startswith("END_")
    is_label = ":" in ends and there[1:2] == [":"]
    return depth > 0 or (bool(there) and not is_closing and not is_label)
