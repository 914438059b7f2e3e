"""The baud rate of a rig that is made of a recording of a serial line: what the times of the recording show."""

import struct
from pathlib import Path
from typing import Any

import pytest
from made_rigs import keys_of, rig_file, save
from pymodbus.framer import FramerRTU

from fieldrig.clock import MS, S
from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.message import LineState, ModbusRequest, ModbusResponse
from fieldrig_devices.replay.calls import replay

# 6.3 on a serial line, unit 11h, with the checksums of pymodbus
REQUEST, RESPONSE = bytes.fromhex("1103006B00037687"), bytes.fromhex("110306022B00000064C8BA")
ASCII = b":1103006B00037E\r\n", b":110306022B0000006455\r\n"


def characters(
    character_ns: float, frames: tuple[bytes, bytes] = (REQUEST, RESPONSE), stamp_ns: int = 1
) -> list[TraceEntry]:
    """Return five exchanges, each character with a stamp of its own."""
    entries = []
    for turn in range(5):
        begin_ns = turn * S
        for frame in frames:
            for number, character in enumerate(frame, 1):
                at_ns = round(begin_ns + number * character_ns) // stamp_ns * stamp_ns
                entries.append(TraceEntry(at_ns, "line", "serial", "", bytes((0, character))))
            begin_ns += 50 * MS
    return entries


def sizes(*answers: tuple[int, float]) -> list[TraceEntry]:
    """Return exchanges in frames with a stamp at their ends, as registers that are read and ms until the answer."""
    entries = []
    for turn, (quantity, answer_ms) in enumerate(answers * 2):
        request = framed(struct.pack(">BBHH", 7, 3, 100, quantity))
        response = framed(bytes((7, 3, 2 * quantity)) + bytes(2 * quantity))
        entries.append(TraceEntry(turn * S, "line", "serial", "master", b"\0" + request))
        entries.append(TraceEntry(round(turn * S + answer_ms * MS), "line", "serial", "unit", b"\0" + response))
    return entries


def framed(body: bytes) -> bytes:
    """Return a frame with the checksum of pymodbus."""
    return body + FramerRTU.compute_CRC(body).to_bytes(2, "big")


def made(entries: list[TraceEntry], folder: Path) -> Path:
    return rig_file(save(entries, folder / "line.jsonl"))


def line_in(path: Path) -> dict[str, Any]:
    found: dict[str, Any] = keys_of(path)["buses"]["line"]
    return found


def line_of(entries: list[TraceEntry], folder: Path) -> dict[str, Any]:
    return line_in(made(entries, folder))


@pytest.mark.parametrize(
    ("baud", "bits", "parity"), [(1200, 11, "E"), (9600, 11, "E"), (9600, 10, "N"), (19200, 10, "N"), (115200, 10, "N")]
)
def test_the_pace_of_characters_is_the_rate_and_the_parity(tmp_path: Path, baud: int, bits: int, parity: str) -> None:
    line = line_of(characters(bits * S / baud, stamp_ns=1000), tmp_path)
    assert (line["baud"], line["parity"], line["stop_bits"]) == (baud, parity, 1)


@pytest.mark.parametrize(("bits", "expected"), [(10, (7, "E")), (11, (8, "E"))])
def test_characters_of_ascii_have_the_usual_format_with_their_bits(
    tmp_path: Path, bits: int, expected: tuple[int, str]
) -> None:
    line = line_of(characters(bits * S / 4800, ASCII), tmp_path)
    assert (line["kind"], line["baud"]) == ("modbus.ascii", 4800)
    assert (line["data_bits"], line["parity"]) == expected


def test_stamps_of_milliseconds_show_no_rate(tmp_path: Path) -> None:
    path = made(characters(10 * S / 9600, stamp_ns=MS), tmp_path)
    assert line_in(path)["baud"] == 19200
    assert "the recording does not say it: set baud" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(("character_ms", "expected"), [(11 / 9.6, (9600, "E")), (10 / 38.4, (38400, "N"))])
def test_longer_answers_show_the_rate(tmp_path: Path, character_ms: float, expected: tuple[int, str]) -> None:
    answers = [(quantity, 6 + (2 * quantity + 5) * character_ms) for quantity in (1, 10, 40)]
    line = line_of(sizes(*answers), tmp_path)
    assert (line["baud"], line["parity"]) == expected


def test_answers_whose_times_follow_no_line_show_no_rate(tmp_path: Path) -> None:
    assert line_of(sizes((1, 20), (10, 90), (40, 40)), tmp_path)["baud"] == 19200


def test_a_fast_answer_needs_a_fast_line(tmp_path: Path) -> None:
    """An answer of 7 bytes after a silence of 3.5 characters of 10 bits, all within 1 ms, needs 105,000 bit/s."""
    path = made(sizes((1, 1)), tmp_path)
    assert line_in(path)["baud"] == 115_200
    assert "its fastest answer needs 115200 bit/s or more" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("form", "expected"), [((38_400, 8, b"N", 2), (38_400, "N", 2)), ((50, 8, b"N", 1), (19_200, "E", 1))]
)
def test_a_format_in_the_recording_is_that_of_the_line(
    tmp_path: Path, form: tuple[int, int, bytes, int], expected: tuple[int, str, int]
) -> None:
    """A line of Modbus with 50 bit/s is none that a rig can have."""
    head = TraceEntry(0, "line", "serial", "", b"\x02" + struct.pack("<IBcB", *form))
    frames = [
        TraceEntry(turn * S + after_ms * MS, "line", "serial", "", b"\0" + frame)
        for turn in range(3)
        for after_ms, frame in ((0, REQUEST), (50, RESPONSE))
    ]
    line = line_of([head, *frames], tmp_path)
    assert (line["baud"], line["parity"], line["stop_bits"]) == expected


@pytest.mark.parametrize("baud", [1200, 9600])
def test_a_rig_of_a_slow_line_plays_its_recording_without_a_difference(tmp_path: Path, baud: int) -> None:
    """The longest answer is 779 ms on the line at 1200 bit/s, which the rig adds at its port alone."""
    answers = [(quantity, 6 + (2 * quantity + 5) * 11_000 / baud) for quantity in (1, 10, 40)]
    path = made(sizes(*answers), tmp_path)
    assert line_in(path)["baud"] == baud
    assert not replay(tmp_path / "line.jsonl", path, time_tolerance_ns=1 * MS).differences


def test_the_answers_of_a_bus_have_no_time_of_a_line(tmp_path: Path) -> None:
    """A trace of a rig has the instants of its members, who do not wait for characters."""
    request = ModbusRequest(7, struct.pack(">BHH", 3, 100, 40), 1, LineState(1, 0))
    response = ModbusResponse(7, bytes((3, 80)) + bytes(80), 1)
    entries = [
        TraceEntry(turn * S + after_ms * MS, "line", "modbus", "", encode(message))
        for turn in range(3)
        for after_ms, message in ((0, request), (2, response))
    ]
    path = made(entries, tmp_path)
    assert line_in(path)["baud"] == 19_200
    assert keys_of(path)["devices"]["unit7"]["turnaround_ms"] == 2
