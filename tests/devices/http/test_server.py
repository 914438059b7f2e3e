"""HTTP on one connection, with requests as in RFC 9112."""

from http import HTTPStatus

import pytest
from hypothesis import given
from hypothesis import strategies as st
from tcp_client import ServedConnection

from fieldrig.clock import S, VirtualClock
from fieldrig_devices.http.messages import Request, Response
from fieldrig_devices.http.server import LONGEST_HEAD, MOST_HELD, serving

GET = b"GET /a.htm HTTP/1.1\r\nHost: plc\r\n\r\n"


class Client:
    def __init__(self, *, is_taking: bool = True, content: bytes = b"page") -> None:
        self.clock = VirtualClock()
        self.asked: list[Request] = []
        self._content = content
        self.connection = ServedConnection(serving(self.clock, self._answer), is_taking=is_taking)

    def _answer(self, request: Request) -> Response:
        self.asked.append(request)
        return Response(HTTPStatus.OK, self._content, "text/plain")

    def send(self, data: bytes) -> bytes:
        return self.connection.send(data)

    def run(self, seconds: float) -> None:
        self.clock.advance_to(self.clock.now_ns() + round(seconds * S))


def status_of(response: bytes) -> bytes:
    return response.partition(b"\r\n")[0]


def test_a_page_is_answered_and_the_connection_stays() -> None:
    client = Client()
    first = client.send(GET)
    assert status_of(first) == b"HTTP/1.1 200 OK"
    assert b"\r\nContent-Length: 4\r\n" in first
    assert b"\r\nContent-Type: text/plain\r\n" in first
    assert first.endswith(b"\r\n\r\npage")
    assert client.send(GET) == first
    assert not client.connection.is_closed


def test_a_request_may_arrive_byte_by_byte() -> None:
    client = Client()
    arrived = b"".join(client.send(bytes((byte,))) for byte in GET)
    assert arrived.endswith(b"page")


def test_head_has_no_content_and_its_length() -> None:
    arrived = Client().send(GET.replace(b"GET", b"HEAD"))
    assert b"\r\nContent-Length: 4\r\n" in arrived
    assert arrived.endswith(b"\r\n\r\n")


def test_an_old_client_gets_its_page_and_the_end() -> None:
    client = Client()
    assert client.send(b"GET /a.htm HTTP/1.0\r\n\r\n").endswith(b"page")
    assert client.connection.is_closed


def test_a_client_may_ask_for_the_end() -> None:
    client = Client()
    assert b"page" in client.send(b"GET / HTTP/1.1\r\nHost: plc\r\nConnection: close\r\n\r\n")
    assert client.connection.is_closed


def test_content_of_a_request_is_skipped() -> None:
    client = Client()
    body = b"GET / HTTP/1.1\r\nHost: plc\r\nContent-Length: 5\r\n\r\nabcde"
    assert client.send(body + GET).count(b"200 OK") == 2


@pytest.mark.parametrize(
    ("target", "path", "query"),
    [
        ("/a%20b.htm?of=x&of=y%26z", "/a b.htm", {"of": ["x", "y&z"]}),
        ("http://plc/a.htm", "/a.htm", {}),
        ("http://plc", "/", {}),
        ("//INDEX.HTM", "//INDEX.HTM", {}),
    ],
)
def test_forms_of_a_target(target: str, path: str, query: dict[str, list[str]]) -> None:
    client = Client()
    client.send(f"GET {target} HTTP/1.1\r\nHost: plc\r\n\r\n".encode())
    assert client.asked == [Request(path, query)]


@pytest.mark.parametrize(
    ("request_bytes", "status"),
    [
        (b"POST / HTTP/1.1\r\nHost: plc\r\nContent-Length: 1\r\n\r\nx", b"405"),
        (b"DELETE / HTTP/1.1\r\nHost: plc\r\n\r\n", b"405"),
        (b"OPTIONS * HTTP/1.1\r\nHost: plc\r\n\r\n", b"405"),
        (b"FOO / HTTP/1.1\r\nHost: plc\r\n\r\n", b"501"),  # RFC 9110, 9.1
        (b"get / HTTP/1.1\r\nHost: plc\r\n\r\n", b"501"),  # methods have a case
        (b"GET / HTTP/2.0\r\nHost: plc\r\n\r\n", b"505"),  # RFC 9110, 15.6.6
        (b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n", b"505"),
        (b"GET /" + b"a" * LONGEST_HEAD + b" HTTP/1.1\r\nHost: plc\r\n\r\n", b"414"),  # in one piece
        (b"GET /" + b"a" * LONGEST_HEAD, b"414"),  # RFC 9112, 3
        (b"A" * (LONGEST_HEAD + 1), b"501"),
        (b"A" * LONGEST_HEAD + b" / HTTP/1.1\r\nHost: plc\r\n\r\n", b"501"),
        (b"GET / HTTP/1.1\r\nHost: plc\r\nX: " + b"y" * LONGEST_HEAD + b"\r\n\r\n", b"431"),
        (b"GET / HTTP/1.1\r\n\r\n", b"400"),  # RFC 9112, 3.2: no Host
        (b"GET / HTTP/1.1\r\nHost: a\r\nHost: b\r\n\r\n", b"400"),
        (b"GET relative HTTP/1.1\r\nHost: plc\r\n\r\n", b"400"),
        (b"GET /%ff HTTP/1.1\r\nHost: plc\r\n\r\n", b"400"),
        (b"GET / HTTP/1.1\r\nHost: plc\r\nContent-Length: 1\r\nContent-Length: 2\r\n\r\nx", b"400"),
        (b"GET / HTTP/1.1\r\nHost: plc\r\nTransfer-Encoding: gzip\r\n\r\n", b"501"),
        (b"\x16\x03\x01\x02\x00\x01\x00\x01\xfc\x03\x03\r\n\r\n", b"400"),  # a TLS client hello
        (b"GET / HTTP/1.1\r\nHost: plc\r\nX: " + b"y" * LONGEST_HEAD, b"431"),
        (b"GET / HTTP/1.1\r\nHost: plc\r\nContent-Length: 999999\r\n\r\n" + b"x" * 70_000, b"413"),
    ],
)
@pytest.mark.parametrize("piece", [1 << 20, 1_000], ids=["whole", "in pieces"])
def test_a_wrong_request_is_refused(request_bytes: bytes, status: bytes, piece: int) -> None:
    client = Client()
    pieces = (request_bytes[first : first + piece] for first in range(0, len(request_bytes), piece))
    assert status_of(b"".join(map(client.send, pieces))).split()[1] == status
    assert not client.asked


@pytest.mark.parametrize(
    ("target", "host", "status"),
    [
        ("http://evil.example/", "plc", b"421"),
        ("http://evil.example:80/a.htm?x=1", "127.0.0.1", b"421"),
        ("HTTP://Evil.Example", "plc", b"421"),
        ("http://evil.example?x", "plc", b"421"),
        ("http://127.0.0.1.evil.example/", "127.0.0.1", b"421"),
        ("https://plc/", "plc", b"421"),  # RFC 9110, 7.4
        ("http://plc@evil.example/", "plc", b"400"),  # RFC 9110, 4.2.4
        ("http:///a.htm", "plc", b"400"),  # RFC 9110, 4.2.1: an empty host
        ("http://?x", "plc", b"400"),
        ("http://plc:99999/", "plc", b"400"),
        ("http:/a.htm", "plc", b"400"),
        ("ftp://plc/a.htm", "plc", b"400"),
        ("http://plc/", "evil.example", b"200"),
        ("http://127.0.0.1:8080/a.htm", "evil.example", b"200"),
        ("http://[::1]/", "plc", b"200"),
        ("/http://evil.example/", "plc", b"200"),
        ("/?u=http://evil.example/", "plc", b"200"),
    ],
)
def test_the_host_of_a_target_in_absolute_form_counts_instead_of_the_field(
    target: str, host: str, status: bytes
) -> None:
    """RFC 9112, 3.2.2: the server ignores the field Host of such a request."""
    response = Client().send(f"GET {target} HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())
    assert status_of(response).split()[1] == status


@pytest.mark.parametrize("lines", [b"\r\n", b"\n", b"\r\n\r\n\n"])
def test_empty_lines_before_a_request_are_skipped(lines: bytes) -> None:
    """RFC 9112, 2.2; old clients sent one behind the content of a POST, so between two requests it counts as well."""
    client = Client()
    assert client.send(lines + GET + lines + GET).count(b"200 OK") == 2
    assert b"".join(client.send(bytes((byte,))) for byte in lines + GET).count(b"200 OK") == 1


@pytest.mark.parametrize("host", ["plc", "plc:80", "10.0.0.1", "[::1]:8080", "a_b-c%20", "plc:"])
def test_a_host_of_rfc_3986_is_taken(host: str) -> None:
    assert status_of(Client().send(f"GET / HTTP/1.1\r\nHost: {host}\r\n\r\n".encode())) == b"HTTP/1.1 200 OK"


@pytest.mark.parametrize(
    "host",
    ["", " ", "\t", ":80", ":",  # RFC 9110, 4.2.1: an http resource has a host
     "a b", "a\tb", "a/b", "u@a", "a:b", "a:1:2", "a:65536", "[::1", "::1", "[::g]", "[1.2.3.4]", "%zz", "<a>", "ä"],
)  # fmt: skip
@pytest.mark.parametrize("version", ["1.0", "1.1"])
def test_another_host_is_refused(host: str, version: str) -> None:
    answer = Client().send(f"GET / HTTP/{version}\r\nHost: {host}\r\n\r\n".encode())
    assert status_of(answer) == b"HTTP/1.1 400 Bad Request"


def test_a_client_that_waits_for_100_continue_is_told_to_go_on() -> None:
    """RFC 9110, 10.1.1; `curl -X GET -d @file` asks so."""
    client = Client()
    asked = client.send(b"GET /a.htm HTTP/1.1\r\nHost: plc\r\nExpect: 100-continue\r\nContent-Length: 3\r\n\r\n")
    assert asked == b"HTTP/1.1 100 Continue\r\n\r\n"
    assert status_of(client.send(b"abc")) == b"HTTP/1.1 200 OK"
    assert status_of(client.send(GET)) == b"HTTP/1.1 200 OK"


@pytest.mark.parametrize(
    "head",
    [
        b"GET / HTTP/1.1\r\nHost: plc\r\nContent-Length: 4\r\nTransfer-Encoding: chunked\r\n\r\n",
        b"GET / HTTP/1.0\r\nTransfer-Encoding: chunked\r\n\r\n",
    ],
)
def test_a_request_with_two_lengths_is_the_last_one(head: bytes) -> None:
    """RFC 9112, 6.1: what follows may be a part of it that another server has read differently."""
    client = Client()
    assert client.send(head + b"0\r\n\r\n" + GET).count(b"HTTP/1.1 200 OK") == 1
    assert client.connection.is_closed


def test_pipelined_requests_wait_while_a_response_is_not_taken() -> None:
    client = Client(is_taking=False)
    client.send(GET * 3)
    assert len(client.asked) == 1
    assert client.connection.accept(5) == b"HTTP/"
    assert len(client.asked) == 1
    client.connection.accept()
    assert len(client.asked) == 2
    client.connection.accept()
    client.connection.accept()
    assert len(client.asked) == 3


def test_a_client_that_takes_nothing_and_asks_on_is_closed() -> None:
    client = Client(is_taking=False)
    for _ in range(MOST_HELD // len(GET) + 10):
        client.send(GET)
    assert client.connection.is_closed
    assert len(client.asked) == 1


def test_half_a_request_is_closed_after_30_s() -> None:
    client = Client()
    for byte in GET[:-1]:
        client.send(bytes((byte,)))
        client.run(1)
    assert client.connection.is_closed


def test_a_response_that_is_taken_slowly_is_not_closed() -> None:
    client = Client(is_taking=False, content=bytes(10_000))
    client.send(GET)
    for _ in range(9):
        client.run(29)
        client.connection.accept(1000)
    assert not client.connection.is_closed
    client.run(61)
    assert client.connection.is_closed


@pytest.mark.parametrize("is_lost", [True, False])
def test_nothing_is_left_to_do_after_the_end(is_lost: bool) -> None:
    client = Client()
    client.send(GET)
    (client.connection.lose if is_lost else client.connection.end)()
    assert client.clock.next_ns() is None
    assert client.connection.is_closed


def test_requests_before_the_end_are_all_answered() -> None:
    client = Client(is_taking=False)
    client.send(GET * 3)
    client.connection.end()
    for _ in range(3):
        assert client.connection.accept().count(b"page") == 1
    assert client.connection.is_closed


PIECES = st.one_of(
    st.binary(max_size=60),
    st.sampled_from(
        [GET, b"GET ", b"/", b"%2e%2e", b" HTTP/1.1\r\n", b"Host: plc\r\n", b"\r\n", b"Content-Length: 3\r\n",
         b"Transfer-Encoding: chunked\r\n", b"5\r\nabcde\r\n0\r\n\r\n", b"Connection: upgrade\r\nUpgrade: h2c\r\n",
         b"Expect: 100-continue\r\n", b"CONNECT plc:80 HTTP/1.1\r\n", b"OPTIONS * HTTP/1.1\r\n"]
    ),
)  # fmt: skip


@given(st.lists(PIECES, max_size=12), st.booleans())
def test_no_bytes_raise_and_every_response_is_whole(pieces: list[bytes], is_taking: bool) -> None:
    client = Client(is_taking=is_taking)
    arrived = b"".join(client.send(piece) for piece in pieces)
    assert arrived == b"" or arrived.startswith(b"HTTP/1.1 ")
    client.run(120)
    client.run(120)
    assert client.connection.is_closed


def test_a_name_of_another_site_reads_nothing() -> None:
    client = Client()
    arrived = client.send(GET.replace(b"Host: plc", b"Host: evil.example:8080"))
    assert status_of(arrived) == b"HTTP/1.1 421 Misdirected Request"
    assert client.asked == []
    assert client.connection.is_closed
