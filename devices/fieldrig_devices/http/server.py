"""HTTP/1.1 on one connection, as a function of bytes and time.

Source: RFC 9110 and 9112; the protocol itself is that of h11.  GET and HEAD are answered, with persistent connections
and pipelining.  A connection without a complete request within `IDLE_NS` is closed, and so is one on which nothing is
taken for so long, and one whose client sends more than `MOST_HELD` bytes ahead without taking its responses.
Left out: TLS, content of requests beyond skipping it, ranges, compression, conditions.
"""

import logging
from collections.abc import Collection
from http import HTTPStatus
from typing import Final

import h11

from fieldrig.clock import Alarm, Clock, S
from fieldrig_devices.connections.connection import TOO_LONG, UNREAD, Connection, Serve
from fieldrig_devices.http.messages import Answer, Request, Response, authority_of, refusal
from fieldrig_devices.http.own_names import is_host, is_own

log = logging.getLogger(__name__)

LONGEST_HEAD: Final = 16 * 1024
"""Longest head of a request, in bytes (414, 431 or 501 for a longer one)."""
MOST_HELD: Final = 64 * 1024
"""Bytes of further requests that are kept while a response is not taken."""
MOST_CONTENT: Final = 64 * 1024
"""Content of a request that is skipped, in bytes (413 for more)."""
IDLE_NS: Final = 30 * S
LIMITS: Final = frozenset((
    HTTPStatus.REQUEST_URI_TOO_LONG, HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE, HTTPStatus.REQUEST_ENTITY_TOO_LARGE,
))  # fmt: skip
"""Refusals of a request that is too long."""
METHODS: Final = (b"GET", b"HEAD")
NOT_ALLOWED: Final = (b"POST", b"PUT", b"DELETE", b"CONNECT", b"OPTIONS", b"TRACE", b"PATCH")
"""Methods that are known and not allowed (405); any other is not implemented (RFC 9110, 9.1)."""
HEADERS: Final = (
    ("Cache-Control", "no-store"),
    ("X-Content-Type-Options", "nosniff"),
    ("Content-Security-Policy", "default-src 'self' 'unsafe-inline'; form-action 'none'; frame-ancestors 'none'"),
)


def serving(clock: Clock, answer: Answer, hosts: Collection[str] = ()) -> Serve:
    """Return the service that answers each request with `answer`; `hosts` are further names of the device."""
    return lambda connection: HttpSession(clock, connection, answer, hosts)


def _new_http() -> h11.Connection:
    return h11.Connection(h11.SERVER, max_incomplete_event_size=LONGEST_HEAD)


def _hosts(request: h11.Request) -> list[bytes]:
    """Return what a request names as its host: the field Host, or instead of it the target, if that has one."""
    authority = authority_of(request.target)
    return [value for name, value in request.headers if name == b"host"] if authority is None else [authority]


def _length(request: h11.Request) -> int:
    """Return the length of the head of a request in bytes, whatever the pieces in which it arrived."""
    fields = sum(len(name) + len(value) + len(": \r\n") for name, value in request.headers)
    return len(_first_line(request)) + len("\r\n") + fields


def _first_line(request: h11.Request) -> bytes:
    return b"%b %b HTTP/%b\r\n" % (request.method, request.target, request.http_version)


def _too_long(head: bytes) -> HTTPStatus:
    """Return the refusal of a head that is too long, by what of it comes first (RFC 9112, 3)."""
    line, end, _ = head[:LONGEST_HEAD].partition(b"\n")
    if end:
        return HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE
    return HTTPStatus.REQUEST_URI_TOO_LONG if b" " in line else HTTPStatus.NOT_IMPLEMENTED


def _is_last(request: h11.Request) -> bool:
    """True for a request after which the connection ends, as its framing may be a smuggled one (RFC 9112, 6.1)."""
    names = {name for name, _ in request.headers}
    return b"transfer-encoding" in names and (b"content-length" in names or request.http_version < b"1.1")


class HttpSession:
    """One connection."""

    def __init__(self, clock: Clock, connection: Connection, answer: Answer, hosts: Collection[str] = ()) -> None:
        self._clock, self._connection, self._answer, self._hosts = clock, connection, answer, hosts
        self._http = _new_http()
        self._held = bytearray()
        self._content = 0
        self._request: h11.Request | None = None
        self._is_closed = self._has_ended = False
        self._unsent = 0
        self._limit = ""
        """The limit that the client has reached."""
        self._timer = Alarm(self._clock)
        self._wait()

    # ---- events

    def received(self, data: bytes) -> None:
        if self._is_closed:
            return
        self._held += data
        if self._connection.unsent and len(self._held) > MOST_HELD:
            self._limit = UNREAD
            self._close()
            return
        self._read()

    def drained(self) -> None:
        self._wait()
        self._read()

    def ended(self) -> None:
        self._has_ended = True
        self._read()

    def lost(self) -> None:
        self._is_closed = True
        self._timer.stop()

    # ---- requests

    def _read(self) -> None:
        """Answer what has arrived, one response at a time."""
        try:
            while not self._is_closed and not self._connection.unsent:
                event = self._http.next_event()
                if event is h11.NEED_DATA:
                    data = self._next_data()
                    if not data:
                        self._continue()
                        self._close_if_ended()
                        return
                    self._http.receive_data(data)
                else:
                    self._take(event)
        except h11.RemoteProtocolError as wrong:
            log.debug("%s: %s", self._connection.peer, wrong)
            status = HTTPStatus(wrong.error_status_hint)
            if status is HTTPStatus.REQUEST_HEADER_FIELDS_TOO_LARGE:
                status = _too_long(self._http.trailing_data[0])
            self._refuse(status)

    def _next_data(self) -> bytes:
        """Return what has arrived, without the empty lines before a request (RFC 9112, 2.2)."""
        if self._http.their_state is h11.IDLE and not self._http.trailing_data[0]:
            while (line := self._held[:2]) == b"\r\n" or line.startswith(b"\n"):
                del self._held[: line.index(b"\n") + 1]
            if self._held == b"\r":
                return b""
        data = bytes(self._held)
        self._held.clear()
        return data

    def _take(self, event: object) -> None:
        match event:
            case h11.Request():
                self._request, self._content = event, 0
                if not event.http_version.startswith(b"1."):
                    self._refuse(HTTPStatus.HTTP_VERSION_NOT_SUPPORTED)
                elif _length(event) > LONGEST_HEAD:
                    self._refuse(_too_long(_first_line(event)))
                elif not all(is_host(value) for value in _hosts(event)):
                    self._refuse(HTTPStatus.BAD_REQUEST)
                elif event.method in NOT_ALLOWED:
                    self._refuse(HTTPStatus.METHOD_NOT_ALLOWED)
                elif event.method not in METHODS:
                    self._refuse(HTTPStatus.NOT_IMPLEMENTED)
                elif not self._is_for_us(event):
                    self._refuse(HTTPStatus.MISDIRECTED_REQUEST)
            case h11.Data():
                self._content += len(event.data)
                if self._content > MOST_CONTENT:
                    self._refuse(HTTPStatus.REQUEST_ENTITY_TOO_LARGE)
            case h11.EndOfMessage():
                assert self._request is not None, "h11 gives a request before its end"
                further = (("Connection", "close"),) if _is_last(self._request) else ()
                self._respond(self._response(self._request), *further)
            case h11.ConnectionClosed():
                self._close()
            case _:  # an upgrade, which the server never takes
                self._close()

    def _is_for_us(self, request: h11.Request) -> bool:
        """Return whether the request has a name of the device as its host; HTTP/1.0 may leave it out.

        Resources of `https` are refused, as they came over no secured connection (RFC 9110, 7.4).
        """
        is_secured = request.target.lower().startswith(b"https:")
        return not is_secured and all(is_own(host.decode("latin-1"), self._hosts) for host in _hosts(request))

    def _response(self, asked: h11.Request) -> Response:
        try:
            request = Request.of_target(asked.target.decode("ascii"))
        except ValueError:
            return refusal(HTTPStatus.BAD_REQUEST)
        return self._answer(request)

    def _continue(self) -> None:
        """Tell a client to send the content that it holds back until then (RFC 9110, 10.1.1)."""
        if self._http.they_are_waiting_for_100_continue:
            going_on = h11.InformationalResponse(status_code=HTTPStatus.CONTINUE, headers=[], reason="Continue")
            self._connection.write(self._http.send(going_on) or b"")

    def _close_if_ended(self) -> None:
        if self._has_ended:
            self._close()

    # ---- responses

    def _refuse(self, status: HTTPStatus) -> None:
        """Send a refusal, and close the connection, because what follows in it cannot be trusted."""
        if status in LIMITS:
            self._limit = TOO_LONG
        if self._http.our_state in (h11.IDLE, h11.SEND_RESPONSE):
            self._respond(refusal(status), ("Connection", "close"), ("Allow", "GET, HEAD"))
        self._close()

    def _respond(self, response: Response, *further: tuple[str, str]) -> None:
        headers = [
            ("Content-Type", response.content_type),
            ("Content-Length", str(len(response.content))),
            *HEADERS,
            *further,
        ]
        head = h11.Response(status_code=response.status, headers=headers, reason=response.status.phrase)
        is_head = self._request is not None and self._request.method == b"HEAD"
        body = b"" if is_head else response.content
        parts = (head, h11.Data(data=body), h11.EndOfMessage())
        self._request = None
        self._connection.write(b"".join(self._http.send(part) or b"" for part in parts))
        self._wait()
        if self._http.our_state is h11.DONE and self._http.their_state is h11.DONE:
            self._begin_next_request()
        else:
            self._close()

    def _begin_next_request(self) -> None:
        """Go on with what h11 has read ahead, in which empty lines may come before the next request."""
        read_ahead, _ = self._http.trailing_data
        self._held[:0] = read_ahead
        self._http = _new_http()

    # ---- limits of time

    def _wait(self) -> None:
        self._timer.stop()
        self._unsent = self._connection.unsent
        if not self._is_closed:
            self._timer.after(IDLE_NS, self._on_timer)

    def _on_timer(self) -> None:
        """Close the connection, unless the client goes on taking its response."""
        if 0 < self._connection.unsent < self._unsent:
            self._wait()
            return
        if self._connection.unsent:
            self._limit = UNREAD
        self._close()

    def _close(self) -> None:
        if self._is_closed:
            return
        self._is_closed = True
        self._timer.stop()
        if self._limit:
            self._connection.cut(self._limit)
        else:
            self._connection.close()
