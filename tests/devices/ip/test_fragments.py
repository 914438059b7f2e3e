"""Fragments of IPv4 packets: RFC 791, 3.2, and RFC 1122, 3.3.2."""

from dataclasses import replace
from ipaddress import IPv4Address
from random import Random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ip_line import CALLER, CONTROLLER, Line, Peer

from fieldrig.clock import S
from fieldrig_devices.ip.fragments import MOST_WAITING, WAIT_NS, Reassembly, fragments_of
from fieldrig_devices.ip.ipv4 import Packet, Protocol
from fieldrig_devices.ip.stack import Stack

# An echo with 60 bytes, as Linux 6.1 sent it into a TUN device whose MTU is 68.
FIRST = bytes.fromhex(
    "450000446f3f20004001a51fbec86465bec8646408004a4244350001000102030405060708090a0b0c0d0e0f10111213141516171819"
    "1a1b1c1d1e1f2021222324252627"
)
SECOND = bytes.fromhex("450000286f3f00064001c535bec86465bec8646428292a2b2c2d2e2f303132333435363738393a3b")
WHOLE = FIRST[20:] + SECOND[20:]


@pytest.mark.parametrize("order", [(FIRST, SECOND), (SECOND, FIRST), (FIRST, FIRST, SECOND), (SECOND, SECOND, FIRST)])
def test_fragments_of_linux_are_put_together(order: tuple[bytes, ...]) -> None:
    reassembly = Reassembly()
    *early, last = [reassembly.take(0, Packet.decode(data)) for data in order]
    assert (early, last) == ([None] * len(early), Packet(CALLER, CONTROLLER, 1, WHOLE, 0x6F3F))


def test_fragments_are_made_as_linux_makes_them() -> None:
    parts = [part.encode() for part in fragments_of(Packet(CALLER, CONTROLLER, 1, WHOLE, 0x6F3F), 68)]
    assert parts == [FIRST, SECOND]
    (whole,) = fragments_of(Packet(CALLER, CONTROLLER, 1, WHOLE), 88)
    assert not whole.is_fragment


def test_a_long_echo_is_answered_in_fragments() -> None:
    """`ping -s 3000`."""
    sent: list[Packet] = []
    stack = Stack(CONTROLLER, 68, lambda data: sent.append(Packet.decode(data)))
    for data in (FIRST, SECOND):
        stack.receive(0, data)
    assert [(part.offset, part.has_more, len(part.payload)) for part in sent] == [(0, True, 48), (48, False, 20)]
    assert b"".join(part.payload for part in sent)[8:] == WHOLE[8:]
    assert stack.next_ns() is None


def test_the_longest_echo_is_answered() -> None:
    line, answers = Line(mtu=1500), Reassembly()
    echo = Packet(CALLER, CONTROLLER, 1, bytes.fromhex("0800f7ff00000000") + bytes(65_507))
    for part in fragments_of(echo, 1500):
        line.controller.receive(0, part.encode())
    found = [answers.take(0, Packet.decode(packet)) for _, sender, packet in line.packets if sender == CONTROLLER]
    assert found[:-1] == [None] * (len(found) - 1)
    assert found[-1] is not None
    assert len(found[-1].payload) == 65_515


def test_fragments_that_do_not_come_in_time_are_reported() -> None:
    peer = Peer()
    peer.stack.receive(0, FIRST)
    assert peer.stack.next_ns() == WAIT_NS
    peer.wait(WAIT_NS / S)
    (late,) = peer.others
    assert late.payload[:2].hex() == "0b01"  # RFC 792: time exceeded, fragment reassembly
    assert late.payload[8:] == FIRST[:28]
    peer.stack.receive(peer.now_ns, SECOND)
    peer.wait(WAIT_NS / S)
    assert len(peer.others) == 1, "nothing is said about a packet whose first fragment did not come"


def test_packets_that_wait_are_limited() -> None:
    reassembly, first = Reassembly(), Packet.decode(FIRST)
    for number in range(MOST_WAITING + 1):
        reassembly.take(0, replace(first, identification=number))
    second = Packet.decode(SECOND)
    assert reassembly.take(0, replace(second, identification=0)) is None, "the oldest was given up"
    assert reassembly.take(0, replace(second, identification=MOST_WAITING)) is not None


@pytest.mark.parametrize(
    ("offset", "size", "has_more"),
    [(0, 44, True), (8, 0, False), (65_528, 8, False), (65_512, 8, True), (40, 4, True)],
)
def test_impossible_fragments_are_refused(offset: int, size: int, has_more: bool) -> None:
    with pytest.raises(ValueError, match="expected multiples of 8"):
        Reassembly().take(0, Packet(CALLER, CONTROLLER, 1, bytes(size), offset=offset, has_more=has_more))


@pytest.mark.parametrize(
    ("offset", "size", "has_more"), [(0, 16, True), (40, 16, True), (8, 8, True), (16, 8, False), (56, 8, False)]
)
def test_fragments_that_overlap_or_contradict_drop_their_packet(offset: int, size: int, has_more: bool) -> None:
    reassembly = Reassembly()
    part = Packet(CALLER, CONTROLLER, 1, bytes(48), offset=0, has_more=True)
    reassembly.take(0, part)
    reassembly.take(0, replace(part, offset=64, payload=bytes(8), has_more=False))
    with pytest.raises(ValueError, match="overlap"):
        reassembly.take(0, replace(part, offset=offset, payload=bytes(range(size)), has_more=has_more))
    assert reassembly.next_ns() is None


@settings(deadline=None)
@given(st.binary(max_size=4000), st.integers(68, 1500), st.integers())
def test_a_packet_arrives_whole_in_any_order(payload: bytes, mtu: int, seed: int) -> None:
    packet = Packet(CALLER, CONTROLLER, Protocol.UDP, payload, 7)
    parts = [part.encode() for part in fragments_of(packet, mtu)]
    assert all(len(part) <= mtu for part in parts)
    Random(seed).shuffle(parts)
    reassembly = Reassembly()
    *early, last = [reassembly.take(0, Packet.decode(part)) for part in parts]
    assert (early, last) == ([None] * len(early), packet)


def test_a_packet_that_gives_way_to_another_one_is_told() -> None:
    dropped: list[int] = []
    reassembly = Reassembly(lambda: dropped.append(1))
    for number in range(10):
        reassembly.take(0, Packet(CALLER, CONTROLLER, 1, bytes(8), number, offset=0, has_more=True))
    assert len(dropped) == 2, "8 wait"


class Payload(bytes):
    """Counts how often lengths are looked at."""

    looks = 0

    def __len__(self) -> int:
        Payload.looks += 1
        return super().__len__()


def test_the_work_for_a_fragment_does_not_grow_with_their_number() -> None:
    """The longest packet in its smallest fragments, last ones first: each is compared with its neighbours only."""
    parts = list(fragments_of(Packet(CALLER, CONTROLLER, Protocol.UDP, bytes(65_512), 7), 28))
    reassembly, Payload.looks = Reassembly(), 0
    *early, last = [reassembly.take(0, replace(part, payload=Payload(part.payload))) for part in reversed(parts)]
    assert early == [None] * 8_188
    assert last is not None
    assert Payload.looks < 10 * len(parts)


UNITS = st.integers(0, 6)
ARRIVALS = st.tuples(UNITS, st.integers(1, 3), st.booleans(), st.sampled_from([0, 0, 0, 1]), st.integers(0, 7))


@settings(deadline=None)
@given(st.lists(ARRIVALS, max_size=14))
def test_fragments_in_any_order_are_what_a_map_of_bytes_says(arrivals: list[tuple[int, int, bool, int, int]]) -> None:
    """RFC 815 with RFC 5722: a byte is filled once, the same fragment may come again, and all else drops the packet."""
    reassembly = Reassembly()
    filled: dict[int, int] = {}
    came: set[tuple[int, bytes]] = set()
    end_of_all: int | None = None
    for unit, units, has_more, variant, cut in arrivals:
        start, size = unit * 8, units * 8 - (0 if has_more else cut)
        payload = bytes((at + variant) % 256 for at in range(start, start + size))
        arrived = dict(zip(range(start, start + size), payload, strict=True))
        whole, is_dropped = None, False
        try:
            whole = reassembly.take(0, Packet(CALLER, CONTROLLER, 17, payload, 1, offset=start, has_more=has_more))
        except ValueError:
            is_dropped = True
        if start == 0 and not has_more:  # no fragment at all
            assert whole is not None
            assert whole.payload == payload
            continue
        if (start, payload) in came:
            assert (whole, is_dropped) == (None, False)
            continue
        behind = end_of_all is not None and (start + size > end_of_all or not has_more)
        short = not has_more and any(at >= start + size for at in filled)
        if behind or short or filled.keys() & arrived.keys():
            assert is_dropped
            filled, came, end_of_all = {}, set(), None
            continue
        assert not is_dropped
        filled |= arrived
        came.add((start, payload))
        end_of_all = end_of_all if has_more else start + size
        if end_of_all is not None and len(filled) == end_of_all:
            assert whole is not None
            assert whole.payload == bytes(filled[at] for at in range(end_of_all))
            filled, came, end_of_all = {}, set(), None
        else:
            assert whole is None


@settings(deadline=None)
@given(st.lists(st.tuples(st.integers(0, 20), st.binary(max_size=40), st.booleans(), st.integers(0, 1)), max_size=30))
def test_no_fragments_raise_anything_but_value_error(parts: list[tuple[int, bytes, bool, int]]) -> None:
    stack = Stack(CONTROLLER, 1500, lambda data: None)
    for offset, payload, has_more, number in parts:
        packet = Packet(IPv4Address("10.0.0.1"), CONTROLLER, 6, payload, number, offset=8 * offset, has_more=has_more)
        stack.receive(0, packet.encode())
    stack.advance(WAIT_NS)
    assert stack.next_ns() is None
