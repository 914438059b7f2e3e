"""Ports in the text of pages and rig files."""

import re
from collections.abc import Mapping

_PORT = re.compile(r"(?:(?:127\.0\.0\.1|0\.0\.0\.0|localhost):|port=|-p |--forward |--socks )(\d{4,5})\b")
"""A port that a program of this machine listens at: in an address, in a call of Python, and as an option."""


def ports_in(text: str) -> set[str]:
    """Return the ports of this machine in the text."""
    return set(_PORT.findall(text))


def exchanged(text: str, numbers: Mapping[str, str]) -> str:
    """The text with ports exchanged for others."""
    return re.sub(rf"(?<![\d.])({'|'.join(numbers)})(?!\d|\.\d)", lambda match: numbers[match[0]], text)
