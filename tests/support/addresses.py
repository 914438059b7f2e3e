"""Addresses that tests may listen on."""

import re
from collections.abc import Mapping

from fieldrig.testing import free_port

__all__ = ["exchanged", "free_port"]


def exchanged(text: str, numbers: Mapping[str, str]) -> str:
    """The text with ports exchanged for others."""
    return re.sub(rf"(?<!\d)({'|'.join(numbers)})(?!\d)", lambda match: numbers[match[0]], text)
