"""Tells a browser from a client of another protocol, by the first line that it sends.

A page of any site can make a browser send bytes to any port of this machine, and a port that skips what it does not
know obeys the lines after the header.  So a port that does not speak HTTP closes at a request line of HTTP, before any
byte behind its method is used.  Source of the methods: IANA, Hypertext Transfer Protocol (HTTP) Method Registry.
Methods are case-sensitive (RFC 9110, 9.1), and words in small letters begin lines of other protocols as well, so those
need the beginning of a target (RFC 9112, 3.2) behind them.  An address with https makes a browser send a hello of TLS,
in which the ticket of a session is text by the author of the page.

A page whose own name leads here (DNS rebinding) chooses the method itself.  So a line that names the protocol and its
version behind a target is a request with any method, as one of SIP and RTSP, which have the same form, is.
"""

import re
from typing import Final

METHODS: Final = frozenset(
    b"ACL BASELINE-CONTROL BIND CHECKIN CHECKOUT CONNECT COPY DELETE GET HEAD LABEL LINK LOCK MERGE MKACTIVITY"
    b" MKCALENDAR MKCOL MKREDIRECTREF MKWORKSPACE MOVE OPTIONS ORDERPATCH PATCH POST PRI PROPFIND PROPPATCH PUT QUERY"
    b" REBIND REPORT SEARCH TRACE UNBIND UNCHECKOUT UNLINK UNLOCK UPDATE UPDATEREDIRECTREF VERSION-CONTROL".split()
)
HELLOS: Final = (b"\x16\x03\x01", b"\x16\x03\x02", b"\x16\x03\x03")
"""The first bytes of TLS: the record of a handshake, and its version (RFC 8446, 5.1).  In Modbus TCP the third is 0."""
MOST: Final = 300
"""Bytes of a connection that are looked at; the longest are the name and port behind CONNECT."""

_METHOD: Final = b"|".join(sorted(METHODS))
_REQUEST: Final = re.compile(
    rb"[\r\n]*(?:(?:%b) |(?i:(?:%b) +(?:/|https?://)|(?:OPTIONS|PRI) +\*|CONNECT +[^\s/]+:\d))" % (_METHOD, _METHOD)
)
_TARGETS: Final = (b"HTTP://", b"HTTPS://")
_TOKEN: Final = rb"[\r\n]*[!#$%&'*+.^_`|~\w-]+"
_NAMED: Final = re.compile(_TOKEN + rb" +\S+ +(?:HTTP|SIP|RTSP)/\d")
"""A request line with any method, up to the version (RFC 9112, 3; RFC 3261, 7.1; RFC 7826, 20.1)."""
_MAY_BE_NAMED: Final = re.compile(_TOKEN + rb"(?: +(?:\S+(?: +[A-Z]*/?)?)?)?")
_VERSION: Final = re.compile(rb"[^\r\n]* (?:HTTP|SIP|RTSP)/\d")
_LONGEST_VERSION: Final = len(b" HTTP/1")


def is_request(line: bytes) -> bool:
    """Return whether a line, or the beginning of one, is that of a request: a method and a target, or TLS."""
    return line.startswith(HELLOS) or _REQUEST.match(line) is not None or _NAMED.match(line) is not None


class FirstLine:
    """The beginning of a connection."""

    def __init__(self) -> None:
        self._seen = b""
        self._is_in_target = False
        """True while the rest of a long target is read, of which only the end is kept."""
        self.is_over = False
        """True when the connection cannot begin with a request of HTTP any more."""

    def is_request(self, data: bytes) -> bool:
        """Return whether the connection begins with a request, given its next bytes."""
        if self._is_in_target:
            return self._ends_as_request(data)
        self._seen += data
        if is_request(self._seen[:MOST]):
            return True
        if len(self._seen) > MOST and _MAY_BE_NAMED.fullmatch(self._seen[:MOST]):
            line, self._seen, self._is_in_target = self._seen.lstrip(b"\r\n"), b"", True
            return self._ends_as_request(line)
        self.is_over = len(self._seen) > MOST or not (
            any(hello.startswith(self._seen) for hello in HELLOS)
            or _may_become_request(self._seen.lstrip(b"\r\n"))
            or _MAY_BE_NAMED.fullmatch(self._seen)
        )
        return False

    def _ends_as_request(self, data: bytes) -> bool:
        """Return whether a line with a long target ends with the name of the protocol."""
        line = self._seen + data
        self._seen = line[-_LONGEST_VERSION:]
        self.is_over = not {*b"\r\n"}.isdisjoint(data)
        return _VERSION.match(line) is not None


def _may_become_request(line: bytes) -> bool:
    word, blank, rest = line.upper().partition(b" ")
    if not blank:
        return any(method.startswith(word) for method in METHODS)
    target = rest.lstrip(b" ")
    return word in METHODS and (
        any(known.startswith(target) for known in _TARGETS)
        or (word == b"CONNECT" and re.fullmatch(rb"[^\s/]*", target) is not None)
    )
