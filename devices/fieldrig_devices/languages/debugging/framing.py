"""The framing of the Debug Adapter Protocol: a header with the length of a message, then the message in JSON.

Source: the protocol's overview, section "Base protocol".  A message that cannot be read is skipped, and a stream whose
headers make no sense is dropped up to the next header.
"""

import json
import logging
import re
from typing import Any, Final

from fieldrig.outside.untrusted import MalformedError, read_json

log = logging.getLogger(__name__)

LONGEST_HEADER: Final = 1_024
LONGEST_MESSAGE: Final = 16 << 20
_END: Final = b"\r\n\r\n"
_LENGTH: Final = re.compile(rb"^Content-Length: *([0-9]{1,9}) *\r?$", re.IGNORECASE | re.MULTILINE)


class Framer:
    """Cuts a stream into messages."""

    def __init__(self) -> None:
        self._waiting = bytearray()

    def feed(self, data: bytes) -> list[Any]:
        """Take bytes of any length, and return the messages that are now complete."""
        self._waiting += data
        messages: list[Any] = []
        while (body := self._next()) is not None:
            try:
                messages.append(read_json(body, LONGEST_MESSAGE))
            except MalformedError as cause:
                log.debug("a message is skipped: %s", cause)
        return messages

    def _next(self) -> bytes | None:
        """Return the next body, or None until it is complete."""
        while True:
            end = self._waiting.find(_END)
            if end < 0:
                if len(self._waiting) > LONGEST_HEADER:
                    del self._waiting[: -len(_END)]
                return None
            length = _LENGTH.search(self._waiting[:end])
            if length is None or int(length[1]) > LONGEST_MESSAGE:
                log.debug("a header is skipped: expected Content-Length of at most %d", LONGEST_MESSAGE)
                del self._waiting[: end + len(_END)]
                continue
            first = end + len(_END)
            last = first + int(length[1])
            if len(self._waiting) < last:
                return None
            body = bytes(self._waiting[first:last])
            del self._waiting[:last]
            return body


def framed(message: Any) -> bytes:
    body = json.dumps(message, ensure_ascii=False).encode()
    return b"Content-Length: %d\r\n\r\n" % len(body) + body
