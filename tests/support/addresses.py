"""Ports in the text of pages and rig files."""

import re
from collections.abc import Mapping


def exchanged(text: str, numbers: Mapping[str, str]) -> str:
    """The text with ports exchanged for others."""
    return re.sub(rf"(?<!\d)({'|'.join(numbers)})(?!\d)", lambda match: numbers[match[0]], text)
