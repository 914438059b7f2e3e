"""Requests that a page of any site can make a browser send to a port of this machine."""

from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig_bus.browsers import METHODS, MOST, FirstLine, is_request

POST = b"POST / HTTP/1.1\r\nHost: 127.0.0.1:29536\r\nContent-Type: text/plain\r\n\r\n< open can0 >"


def begins_with_request(*parts: bytes) -> bool:
    first = FirstLine()
    for part in parts:
        if first.is_request(part):
            return True
        if first.is_over:
            return False
    return False


# IANA, Hypertext Transfer Protocol (HTTP) Method Registry.
REGISTERED = """
    ACL BASELINE-CONTROL BIND CHECKIN CHECKOUT CONNECT COPY DELETE GET HEAD LABEL LINK LOCK MERGE MKACTIVITY MKCALENDAR
    MKCOL MKREDIRECTREF MKWORKSPACE MOVE OPTIONS ORDERPATCH PATCH POST PRI PROPFIND PROPPATCH PUT QUERY REBIND REPORT
    SEARCH TRACE UNBIND UNCHECKOUT UNLINK UNLOCK UPDATE UPDATEREDIRECTREF VERSION-CONTROL
"""


def test_every_registered_method_is_known() -> None:
    assert set(REGISTERED.encode().split()) == METHODS


@pytest.mark.parametrize("method", sorted(METHODS))
def test_every_method_is_one_however_it_arrives(method: bytes) -> None:
    line = method + b" /a HTTP/1.1\r\n"
    assert begins_with_request(line)
    assert begins_with_request(*(bytes((byte,)) for byte in line))
    assert begins_with_request(b"\r\n" + line)  # RFC 9112, 2.2: an empty line before a request is skipped
    small = line.lower()
    assert begins_with_request(small)
    assert begins_with_request(*(bytes((byte,)) for byte in small))
    assert begins_with_request(method.capitalize() + b"  https://127.0.0.1/ HTTP/2")


@pytest.mark.parametrize("line", [b"connect 127.0.0.1:80 http/1.1", b"Options * HTTP/1.1", b"CONNECT x:1 HTTP/1.1"])
def test_the_forms_of_a_target_without_a_path_are_known(line: bytes) -> None:
    assert begins_with_request(line)
    assert begins_with_request(*(bytes((byte,)) for byte in line))


@pytest.mark.parametrize("version", [b"HTTP/1.1", b"SIP/2.0", b"RTSP/1.0"])
@pytest.mark.parametrize("target", [b"/", b"*", b"sip:a@127.0.0.1", b"/" + b"a" * 9000])
@pytest.mark.parametrize("method", [b"FOO", b"INVITE", b"m-search"])
def test_a_line_with_any_method_is_a_request_by_the_protocol_that_it_names(
    method: bytes, target: bytes, version: bytes
) -> None:
    line = b"%b %b %b\r\nHost: a\r\n\r\n" % (method, target, version)
    assert begins_with_request(line)
    assert begins_with_request(b"\r\n" + line)
    assert begins_with_request(*(bytes((byte,)) for byte in line))


@pytest.mark.parametrize(
    "line", [b"move 1 2\r", b"get /a\r\n", b"a " + b"b" * 900 + b"\rx HTTP/1.1", b"read a HTTPX/1"]
)
def test_a_line_that_names_no_protocol_is_none(line: bytes) -> None:
    assert begins_with_request(line) is line.startswith(b"get /")
    assert not begins_with_request(b"x" + line)


# The first bytes of Chromium's hello with versions of TLS 1.0 and 1.2 in the record (RFC 8446, 5.1 and appendix D).
@pytest.mark.parametrize("hello", [b"\x16\x03\x01\x06\xe6\x01\x00\x06\xe2\x03\x03", b"\x16\x03\x03\x02\x00\x01"])
def test_https_is_a_request_as_well(hello: bytes) -> None:
    assert begins_with_request(hello + b"\r\n< open can0 >")
    assert begins_with_request(*(bytes((byte,)) for byte in hello))
    assert is_request(hello)


@pytest.mark.parametrize(
    "line",
    [b"< open can0 >", b"AT\r", b"ATDT200\r", b"P\r", b"O\r", b"t1230\r", b"G", b"GO\r", b"GETTING on", b"PUTS x",
     b"get position\r", b"copy a b\r", b"link 3\r", b"connect box\r", b"options\r", b"HELLO / HTTP\r",
     b"\xff\xfd\x2c", b"\x00\x01\x00\x00\x00\x06\x01\x03", b"\r\r\rV\r", b"USER x\r\n", b":0103",
     b"\x16\x03\x00\x00\x00\x06\x01\x03"],  # the last is request 1603h of a Modbus client
)  # fmt: skip
def test_a_line_of_another_protocol_is_none(line: bytes) -> None:
    assert not begins_with_request(line)
    assert not is_request(line)


@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=6))
def test_parts_make_no_difference(data: bytes, cuts: list[int]) -> None:
    places = [0, *sorted(cut % (len(data) + 1) for cut in cuts), len(data)]
    parts = [data[start:stop] for start, stop in pairwise(places)]
    assert begins_with_request(*parts) == begins_with_request(data)


@given(st.binary(min_size=MOST + 1, max_size=MOST + 50))
def test_the_look_at_the_first_line_ends(data: bytes) -> None:
    first = FirstLine()
    assert first.is_request(data) or first.is_request(b"\n") or first.is_over
