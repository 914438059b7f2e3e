"""Tells a browser from a client of another protocol, by the first line that it sends.

A page of any site can make a browser send bytes to any port of this machine, and a port that skips what it does not
know obeys the lines after the header.  So a port that does not speak HTTP closes at a method of HTTP, before any byte
of that line is used.  Source of the methods: RFC 9110, 9.3; RFC 5789; RFC 4918 (WebDAV); RFC 9113, 3.4.  An address
with https makes it send a hello of TLS, in which the ticket of a session is text by the author of the page.
"""

from typing import Final

METHODS: Final = frozenset(
    b"GET HEAD POST PUT DELETE CONNECT OPTIONS TRACE PATCH PRI"
    b" PROPFIND PROPPATCH MKCOL COPY MOVE LOCK UNLOCK SEARCH REPORT".split()
)
LONGEST: Final = max(map(len, METHODS)) + 1
HELLOS: Final = (b"\x16\x03\x01", b"\x16\x03\x02", b"\x16\x03\x03")
"""The first bytes of TLS: the record of a handshake, and its version (RFC 8446, 5.1).  In Modbus TCP the third is 0."""


def is_request(line: bytes) -> bool:
    """Return whether a line, or the beginning of one, is that of a request: a method and a target, or TLS."""
    method, blank, _ = line.lstrip(b"\r\n")[:LONGEST].partition(b" ")
    return line.startswith(HELLOS) or (bool(blank) and method in METHODS)


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
        self.is_over = bool(word) and not any(start.startswith(word[:LONGEST]) for start in (*METHODS, *HELLOS))
        self.is_over = self.is_over or len(self._seen) > 2 * LONGEST
        return False
