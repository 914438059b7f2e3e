"""The messages of a socket of the page: MessagePack, in both directions.

From the server: one array for each tick, `[number, message, ...]`, each message a map with its type at "t".
From the page: a map each, {"t": "want", "topic": NAME, "wish": ...} and {"t": "seen", "number": ...}.
"""

from collections.abc import Sequence
from typing import Any, Final

import msgpack

from fieldrig.outside.untrusted import MalformedError, shown

LONGEST: Final = 1 << 16
"""Longest message of a page in bytes."""
MOST_ITEMS: Final = 4096
"""Most items of one array or map in a message of a page."""


def packed(number: int, messages: Sequence[Any]) -> bytes:
    """Return the bytes of one tick."""
    data: bytes = msgpack.packb([number, *messages])
    return data


def taken(data: bytes) -> dict[str, Any]:
    """Return a message of a page.  MalformedError for anything but one map with texts as keys, within the limits."""
    if len(data) > LONGEST:
        raise MalformedError(f"{len(data)} bytes, expected at most {LONGEST}")
    try:
        message = msgpack.unpackb(
            data, max_array_len=MOST_ITEMS, max_map_len=MOST_ITEMS, max_ext_len=0, strict_map_key=True
        )
    except (ValueError, msgpack.UnpackException) as cause:  # what it raises is one or the other
        raise MalformedError(f"not MessagePack: {cause}") from cause
    if not isinstance(message, dict) or not all(isinstance(key, str) for key in message):
        raise MalformedError(f"expected a map, found {shown(message)}")
    return message
