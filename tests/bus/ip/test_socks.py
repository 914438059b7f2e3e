"""SOCKS 5: RFC 1928."""

from contextlib import suppress
from ipaddress import IPv4Address
from itertools import pairwise

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_bus.ip.socks import Handshake, Request, reply

# As curl 7.88 sends it for ftp://190.200.100.100, and RFC 1928's form of the same address as a name.
HELLO = bytes.fromhex("05 02 00 01")
CONNECT = bytes.fromhex("05 01 00 01 be c8 64 64 00 15")
BY_NAME = bytes.fromhex("05 01 00 03 0f 3139302e3230302e3130302e313030 00 15")
CONTROLLER = IPv4Address("190.200.100.100")


@pytest.mark.parametrize("request_bytes", [CONNECT, BY_NAME])
def test_a_client_asks_for_an_address(request_bytes: bytes) -> None:
    handshake = Handshake()
    assert handshake.feed(HELLO) == (b"\x05\x00", None)
    assert handshake.feed(request_bytes + b"USER") == (b"", Request(CONTROLLER, 21))
    assert handshake.rest == b"USER"


@pytest.mark.parametrize(
    ("request_bytes", "refusal"),
    [
        ("05 02 00 01 bec86464 0015", 7),  # BIND
        ("05 03 00 01 bec86464 0015", 7),  # UDP ASSOCIATE
        ("05 01 00 04 00000000000000000000000000000001 0015", 8),
        ("05 01 00 03 03 706c63 0015", 8),
        ("05 01 00 03 01 ff 0015", 8),
        ("05 01 00 03 00 0015", 8),
        ("05 01 00 02", 8),  # an unknown type of address has no known length
        ("05 01 00 00 01 00 00", 8),
        ("05 02 00 07", 7),
        ("05 09 00 01 bec86464 0015", 7),
        ("04 01", 1),
        ("474554202f", 1),
    ],
)
def test_other_requests_are_refused(request_bytes: str, refusal: int) -> None:
    handshake = Handshake()
    handshake.feed(HELLO)
    _, request = handshake.feed(bytes.fromhex(request_bytes))
    assert request is not None
    assert request.refusal == refusal


@pytest.mark.parametrize("data", ["04 01 0015 bec86464 00", "474554202f", "05 01 02", "05 00"])
def test_clients_of_other_protocols_are_refused(data: str) -> None:
    with pytest.raises(ValueError, match="expected"):
        Handshake().feed(bytes.fromhex(data) + bytes(5))


@settings(deadline=None)
@given(st.lists(st.integers(1, len(HELLO + CONNECT))))
def test_the_conversation_may_come_in_parts(cuts: list[int]) -> None:
    data, handshake, answers, requests = HELLO + CONNECT, Handshake(), b"", []
    places = [0, *sorted(cuts), len(data)]
    for start, end in pairwise(places):
        answer, request = handshake.feed(data[start:end])
        answers += answer
        requests += [request] if request is not None else []
        if requests:
            break
    assert (answers, requests) == (b"\x05\x00", [Request(CONTROLLER, 21)])


@settings(deadline=None)
@given(st.lists(st.binary(max_size=30) | st.sampled_from([HELLO, CONNECT, BY_NAME])))
def test_arbitrary_bytes_raise_nothing_but_value_error(pieces: list[bytes]) -> None:
    handshake = Handshake()
    with suppress(ValueError):
        for piece in pieces:
            handshake.feed(piece)


def test_a_reply_has_an_empty_address() -> None:
    assert reply(0) == bytes.fromhex("05 00 00 01 00000000 0000")
