"""Values of programs as texts."""

from collections.abc import Mapping
from typing import Any


def shown(variable: Mapping[str, Any]) -> str:
    """Return the value of a variable in an answer as its language writes it."""
    return str(variable["text"]) or text_of(variable["value"])


def text_of(value: Any) -> str:
    """Return a value as the languages write it; nothing for None."""
    if value is None:
        return ""
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    return f"'{value}'" if isinstance(value, str) else str(value)
