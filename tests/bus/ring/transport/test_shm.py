"""Messages in shared memory, and the socket over which its ends find each other."""

import mmap
import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest
from any_ring import ADDRESSES, StarAt
from hypothesis import given, settings
from hypothesis import strategies as st
from ring_kinds import StarRing, hearing, shm

from fieldrig.errors import BusError
from fieldrig_bus.ring.sercos.shm import RingShm
from fieldrig_bus.ring.sercos.star import RingStarSettings
from fieldrig_bus.ring.transport.image import SLOTS, Image
from fieldrig_bus.ring.transport.shm_carrier import is_available

pytestmark = [pytest.mark.system, pytest.mark.skipif(not is_available(), reason="needs memfd and eventfd")]

ALL_WELL = dict.fromkeys(ADDRESSES, (True, True))


@pytest.fixture
def images() -> Iterator[tuple[Image, Image]]:
    """A writer and a reader of one image."""
    writer = Image.make("test", 100)
    reader = Image(os.dup(writer.fd))
    yield writer, reader
    reader.close()
    writer.close()


@settings(max_examples=30, deadline=None)
@given(st.lists(st.lists(st.binary(max_size=100), max_size=SLOTS), max_size=6))
def test_messages_are_read_once_and_in_order(bursts: list[list[bytes]]) -> None:
    writer = Image.make("test", 100)
    reader = Image(os.dup(writer.fd))
    for burst in bursts:
        for message in burst:
            writer.write(message)
        assert list(reader.read()) == burst
    reader.close()
    writer.close()


def test_a_reader_that_was_overtaken_takes_what_is_still_there(images: tuple[Image, Image]) -> None:
    writer, reader = images
    for number in range(40):
        writer.write(bytes([number]))
    assert list(reader.read()) == [bytes([number]) for number in range(40 - SLOTS, 40)]


def test_numbers_go_round(images: tuple[Image, Image]) -> None:
    writer, reader = images
    writer.number = reader.number = 0xFFFF_FFFE
    for message in (b"a", b"b", b"c"):
        writer.write(message)
    assert (list(reader.read()), writer.number) == ([b"a", b"b", b"c"], 1)


def test_a_message_that_is_only_half_there_is_passed_over(images: tuple[Image, Image]) -> None:
    writer, reader = images
    writer.write(b"whole")
    writer.write(b"broken")
    writer.write(b"whole again")
    with mmap.mmap(writer.fd, 0) as memory:
        place = memory.find(b"broken")
        memory[place : place + 3] = b"xxx"
    assert list(reader.read()) == [b"whole", b"whole again"]


def test_a_message_that_is_too_long_is_refused(images: tuple[Image, Image]) -> None:
    with pytest.raises(ValueError, match="101 bytes: expected at most 100"):
        images[0].write(bytes(101))
    assert list(images[1].read()) == []


@pytest.fixture
def ring() -> Iterator[StarRing]:
    with shm() as ring:
        for name, address in ADDRESSES.items():
            ring.join(name, address)
        ring.cycle()
        yield ring


@pytest.mark.parametrize(
    "word",
    [
        b"",
        b"hello",
        b"[]",
        b'{"process": "belt"}',
        b'{"process": 5, "stations": []}',
        b'{"process": "x", "stations": [["x"]]}',
        b'{"process": "x", "stations": [["x", ["y"]]]}',
        b"\xff" * 100,
    ],
)
def test_unknown_clients_are_disconnected(ring: StarRing, word: bytes) -> None:
    with socket.socket(socket.AF_UNIX, socket.SOCK_SEQPACKET) as stranger:
        stranger.connect(str(ring.at["max4"].path("ring0.ring")))
        stranger.setblocking(False)
        if word:
            stranger.send(word)
        else:
            stranger.shutdown(socket.SHUT_WR)
        ended: list[bool] = []

        def has_ended() -> bool:
            try:
                ended.append(stranger.recv(64) == b"")
            except BlockingIOError:
                return False
            except ConnectionError:
                ended.append(True)
            return True

        ring.pump(has_ended)
        assert ended == [True]
    assert hearing(ring) == ALL_WELL


def test_a_process_that_says_its_name_again_takes_its_own_place(ring: StarRing) -> None:
    """The end of its old socket may be noticed after the beginning of its new one."""
    old = ring.buses.pop("belt")
    ring.stations.pop("belt")
    ring.join("belt", 3)
    ring.loop.run_until_complete(old.close("belt"))
    assert hearing(ring) == ALL_WELL


def test_a_cycle_too_long_for_the_image_is_not_sent(ring: StarRing) -> None:
    spokes = ring.star._spokes
    assert spokes is not None
    spokes.spread(bytes(100_000), ())
    assert hearing(ring) == ALL_WELL


def test_a_folder_with_too_long_a_path_is_an_error_with_a_remedy(ring: StarRing, tmp_path: Path) -> None:
    at = StarAt("max4", ring.clock, "max4", tmp_path / ("x" * 120))
    with pytest.raises(BusError, match="is not available") as refused:
        ring.buses["max4"].carrier.hold(at, ring.star)
    assert "run" in refused.value.remedy


def test_a_ring_is_a_bus_with_settings_of_its_own() -> None:
    bus = RingShm("ring0", RingStarSettings(order=["belt"], mbaud=16, realtime=True))
    assert (bus.settings.order, bus.settings.realtime, bus.family) == (["belt"], True, "ring")
