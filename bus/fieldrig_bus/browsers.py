"""Tells a browser from a client of another protocol, by the first line that it sends.

A page of any site can make a browser send bytes to any port of this machine, and a port that skips what it does not
know obeys the lines after the header.  So a port that does not speak HTTP closes at a method of HTTP, before any byte
of that line is used.  Source of the methods: RFC 9110, 9.3; RFC 5789; RFC 4918 (WebDAV); RFC 9113, 3.4.
"""

from typing import Final

METHODS: Final = frozenset(
    b"GET HEAD POST PUT DELETE CONNECT OPTIONS TRACE PATCH PRI"
    b" PROPFIND PROPPATCH MKCOL COPY MOVE LOCK UNLOCK SEARCH REPORT".split()
)
LONGEST: Final = max(map(len, METHODS)) + 1


def is_request(line: bytes) -> bool:
    """Return whether a line, or the beginning of one, is that of a request: a method and a target."""
    method, blank, _ = line.lstrip(b"\r\n")[:LONGEST].partition(b" ")
    return bool(blank) and method in METHODS


class FirstLine:
    """The beginning of a connection."""

    def __init__(self) -> None:
        self._seen = b""
        self.is_over = False
        """True when the connection can't begin with a method of HTTP any more."""

    def is_request(self, data: bytes) -> bool:
        """Return whether the connection begins with a request, given its next bytes."""
        self._seen += data[: LONGEST + 2]
        if is_request(self._seen):
            return True
        word = self._seen.lstrip(b"\r\n")
        self.is_over = bool(word) and not any(method.startswith(word[:LONGEST]) for method in METHODS)
        self.is_over = self.is_over or len(self._seen) > 2 * LONGEST
        return False
