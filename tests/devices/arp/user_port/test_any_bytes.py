"""Bytes of any kind at the USER port: nothing is raised, and only a complete valid frame changes anything."""

import struct
import zlib

import pytest
from arp_user_port import PortBench, an_object, fcs, frame
from hypothesis import given, settings
from hypothesis import strategies as st

from fieldrig_devices.arp.user_port.messages import Command

COMMANDS = st.one_of(st.sampled_from([command.value for command in Command]), st.integers(0, 255))
SOURCE = "L:\nV1 += 1\nWAIT 1\nGOTO L"


def everything(bench: PortBench) -> tuple[object, ...]:
    access, program = bench.access, bench.access.program
    assert program is not None
    parameters = access.parameters
    return (
        list(access.V), list(access.F), list(access.O), parameters.ram[0] + parameters.ram[1] + parameters.ram[2],
        bench.store.load(), access.state, program.state, program.breakpoints,
    )  # fmt: skip


def good_bodies(wire: bytes) -> bool:
    """True if the data may contain a valid frame."""
    for part in wire.split(b"~"):
        octets, rest = bytearray(), iter(part)
        for octet in rest:
            octets.append(next(rest, 0) ^ 0x20 if octet == 0x7D else octet)
        if len(octets) >= 6 and fcs(bytes(octets[:-2])) == octets[-2:]:
            return True
    return False


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.one_of(st.binary(max_size=300), st.just(b"~"), st.just(b"\x7d")), max_size=20))
def test_noise_changes_nothing_and_is_not_answered(chunks: list[bytes]) -> None:
    bench = PortBench(SOURCE)
    before = everything(bench)
    for chunk in chunks:
        bench.user.deliver(chunk)
    bench.run_for(5)
    if not good_bodies(b"".join(chunks)):
        assert everything(bench) == before
        assert bench.heard() == []


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(COMMANDS, st.binary(max_size=256), st.integers(0, 255)), max_size=12), st.booleans())
def test_any_valid_frames_are_answered_once_each(requests: list[tuple[int, bytes, int]], enabled: bool) -> None:
    bench = PortBench(SOURCE, is_enabled=enabled)
    for command, data, sequence in requests:
        heard = [body for body in bench.send(command, data, sequence=sequence) if body[3] not in (0xE0, 0xE1)]
        assert [body[:4] for body in heard] == ([bytes((1, 1, sequence, command | 0x80))] if command < 0x60 else [])
        bench.run_for(2)


READING = {0x01, 0x02, 0x10, 0x11, 0x20, 0x34, 0x35, 0x41, 0x44, 0x50, 0x51, 0x52, 0x33}


@pytest.mark.long
@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(sorted(READING)), st.binary(max_size=60)), max_size=10))
def test_requests_that_read_change_nothing(requests: list[tuple[int, bytes]]) -> None:
    bench = PortBench(SOURCE)
    before = everything(bench)
    for command, data in requests:
        bench.send(command, data)
    bench.run_for(20)
    assert everything(bench) == before


@pytest.mark.long
@settings(max_examples=60, deadline=None)
@given(st.data())
def test_a_download_with_any_frame_lost_doubled_or_damaged_is_all_or_nothing(data: st.DataObject) -> None:
    """A PC that stops at once: its data may be damaged, and none of them are repeated."""
    new = an_object("\n".join(["V2 == 7"] * 40), name="NEW")
    bench = PortBench(SOURCE)
    frames = [bytes((1, 1, 1, 0x30)) + struct.pack("<II", len(new), zlib.crc32(new))]
    for offset in range(0, len(new), 60):
        frames.append(bytes((1, 1, len(frames) + 1, 0x31)) + struct.pack("<I", offset) + new[offset : offset + 60])
    frames.append(bytes((1, 1, len(frames) + 1, 0x32)))
    is_whole = True
    for body in frames:
        wire = bytearray(frame(body))
        match data.draw(st.sampled_from(("good", "good", "good", "good", "good", "lost", "twice", "damaged"))):
            case "lost":
                is_whole, wire = False, bytearray()
            case "twice":
                wire *= 2
            case "damaged":
                is_whole = False
                wire[data.draw(st.integers(1, len(wire) - 2))] ^= 1 << data.draw(st.integers(0, 7))
        bench.user.deliver(bytes(wire))
    bench.run_for(100)  # compiling takes 5 us for each octet
    assert bench.access.program_name == ("NEW" if is_whole else "program")
    bench.enable()
    assert (bench.access.V[1] == 1_000, bench.access.V[2] == 7_000) == (not is_whole, is_whole)
