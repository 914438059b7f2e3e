"""Describe a question to the control service in a user's words, for the message that refuses it."""

from typing import Any, Final

from fieldrig.text.yaml_value import show

LONGEST: Final = 60


def asked(verb: str, message: Any) -> str:
    """Return `restart io` for the verb `restart` with the message `{"name": "io"}`."""
    match message:
        case None:
            return verb
        case dict() if len(message) == 1:
            (value,) = message.values()
            return f"{verb} {_words(value)}"
        case dict():
            return f"{verb} {', '.join(f'{key} {_words(value)}' for key, value in message.items())[:LONGEST]}"
    return f"{verb} {_words(message)}"


def _words(value: Any) -> str:
    match value:
        case str():
            text = value
        case list() if all(isinstance(word, str) for word in value):
            text = " ".join(value)
        case dict():
            text = " ".join(f"{key}={show(item)}" for key, item in value.items())
        case _:
            text = show(value)
    if not text.isprintable():  # it comes from outside, and goes on one line of a log
        text = ascii(text)[1:-1]
    return text if len(text) <= LONGEST else f"{text[: LONGEST - 3]}..."
