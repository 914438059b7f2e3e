"""A fault in the words of a person: `drop node=sensor probability=0.5`."""

import shlex
from collections.abc import Mapping, Sequence
from typing import Any


def fault_of_words(words: Sequence[str]) -> dict[str, str]:
    """Return the fault; values stay texts, as only the bus knows whether `data=10` is a number.

    ValueError, in a sentence, for a word that is no key.
    """
    given: dict[str, str] = {}
    for position, word in enumerate(words):
        key, equals, text = word.partition("=")
        if not equals and position == 0:
            key, text = "what", word
        elif not equals or not key:
            raise ValueError(f"{word!r} is no key of a fault: write it like probability=0.1")
        if key in given:
            raise ValueError(f"{key} is there twice")
        given[key] = text
    return given


def words_of_fault(fault: Mapping[str, Any]) -> str:
    """Return a fault as one text; `split_words` and `fault_of_words` take it apart."""
    words = [str(fault["what"]), *(f"{key}={_shown(value)}" for key, value in fault.items() if key != "what")]
    return " ".join(_quoted(word) for word in words)


def split_words(text: str) -> list[str]:
    """Return the words of a text; a part in quotes belongs to one of them: `drop when="tank/level > 1"`.

    ValueError, in a sentence, for a quote without its end.
    """
    try:
        return shlex.split(text) if "'" in text or '"' in text else text.split()
    except ValueError as wrong:
        raise ValueError(f"{text!r} has a quote without its end") from wrong


def _quoted(word: str) -> str:
    """Return a word as `split_words` takes it apart, with quotes only where it needs them."""
    return shlex.quote(word) if any(sign.isspace() or sign in "'\"\\" for sign in word) else word


def _shown(value: object) -> str:
    return str(value).lower() if isinstance(value, bool) else str(value)
