"""The words of an expression: brackets, commas, texts in quotes, and everything else between blanks."""

import re
from typing import Final

_WORD: Final = re.compile(r"""\s*("[^"]*"|'[^']*'|[(),]|[^\s(),'"]+)""")


def words_of(text: str) -> list[str]:
    """Return the words.  ValueError, with what was expected, for a quote without an end."""
    words, at = list[str](), 0
    while text[at:].strip():
        found = _WORD.match(text, at)
        if found is None:
            raise ValueError(
                f"the quote at {text[at:].strip()[:20]!r} has no end\nexpected another one behind the text"
            )
        words.append(found[1])
        at = found.end()
    return words
