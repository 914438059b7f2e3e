"""Rules of a TextMate grammar."""

from collections.abc import Iterable, Sequence
from typing import Any


def words(scope: str, names: Iterable[str], *, any_case: bool = True) -> dict[str, str]:
    """Return the rule of whole words; the longest comes first, so that none hides another."""
    ordered = "|".join(sorted(names, key=lambda name: (-len(name), name)))
    return {"name": scope, "match": rf"{'(?i)' if any_case else ''}\b(?:{ordered})\b"}


def match(scope: str, pattern: str) -> dict[str, str]:
    return {"name": scope, "match": pattern}


def block(scope: str, begin: str, end: str, *, is_nested: bool = False) -> dict[str, Any]:
    """Return the rule of what goes over lines, such as a comment; a nested one may have itself inside."""
    inner = [{"include": f"#{scope}"}] if is_nested else []
    return {"name": scope, "begin": begin, "end": end, "patterns": inner}


def grammar(name: str, scope: str, rules: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return a grammar; its rules are tried in their order at each place of a line."""
    repository = {rule["name"]: rule for rule in rules}
    return {
        "name": name,
        "scopeName": scope,
        "patterns": [{"include": f"#{rule['name']}"} for rule in rules],
        "repository": repository,
    }
