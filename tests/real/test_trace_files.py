"""Trace files in the hands of the programs that they are written for: tshark, log2asc, python-can."""

import io
import json
import subprocess
from collections.abc import Callable
from pathlib import Path
from typing import Any

import can
import pytest
from dial_bench import Bench
from dial_peer import PAGE

from fieldrig.traces.trace import TraceEntry
from fieldrig_bus.can import codec as can_codec
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus import codec as modbus_codec
from fieldrig_bus.modbus.message import ModbusMessage, ModbusRequest, ModbusResponse
from fieldrig_bus.traces import asc, candump, pcap, pcapng

pytestmark = pytest.mark.real

START_UNIX_NS = 1_700_000_000_000_000_000

CAN = [
    CanFrame(0x605, bytes.fromhex("40 00 10 00 00 00 00 00")),
    CanFrame(0x1ABCDEF0, b"\x01\x02", is_extended=True),
    CanFrame(0x123, is_remote=True, remote_length=4),
    CanFrame(0x124, bytes(range(12)), is_fd=True, is_bit_rate_switched=True),
]
MODBUS: list[tuple[str, ModbusMessage]] = [
    ("tcp:1", ModbusRequest(1, bytes.fromhex("03 00 6b 00 03"), 7)),
    ("drive", ModbusResponse(1, bytes.fromhex("03 06 02 2b 00 00 00 64"), 9)),
    ("tcp:2", ModbusRequest(1, bytes.fromhex("06 00 01 00 03"), 8)),
    ("drive", ModbusResponse(1, bytes.fromhex("86 02"), 9)),
]
ENTRIES = [
    *(TraceEntry(n * 1000, "can0", "can", f"node{n}", can_codec.encode(frame)) for n, frame in enumerate(CAN)),
    *(
        TraceEntry(n * 1000, "mb", "modbus", name, modbus_codec.encode(message))
        for n, (name, message) in enumerate(MODBUS)
    ),
    TraceEntry(9000, "com1", "serial", "modem", b"\x00AT\r"),
]


def output(*command: str) -> str:
    return subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout


def tshark(file: Path, *arguments: str) -> Any:
    return [
        packet["_source"]["layers"]
        for packet in json.loads(output("tshark", "-r", str(file), "-T", "json", *arguments))
    ]


def written(path: Path, write: Callable[..., int], count: int) -> Path:
    with path.open("wb") as file:
        assert write(ENTRIES, file, START_UNIX_NS) == count
    return path


@pytest.fixture
def capture(tmp_path: Path) -> Path:
    return written(tmp_path / "trace.pcapng", pcapng.write, len(ENTRIES))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return written(tmp_path / "trace.log", candump.write, len(CAN))


def test_tshark_decodes_can_frames(capture: Path) -> None:
    first, extended, remote = (packet["can"] for packet in tshark(capture, "-Y", "can"))
    (fd,) = (packet["canfd"] for packet in tshark(capture, "-Y", "canfd"))
    assert (first["can.id"], first["can.len"]) == ("1541", "8")
    assert (extended["can.id"], extended["can.flags.xtd"]) == (str(0x1ABCDEF0), "1")
    assert remote["can.flags.rtr"] == "1"
    assert fd["can.len"] == "12"
    assert fd["canfd.flags.brs"] == "1"


def test_tshark_says_bus_and_sender_and_time(capture: Path) -> None:
    fields = ("frame.interface_name", "frame.comment", "frame.time_epoch")
    arguments = [word for field in fields for word in ("-e", field)]
    rows = [line.split("\t") for line in output("tshark", "-r", str(capture), "-T", "fields", *arguments).splitlines()]
    assert rows[1] == ["can0", "node1", "1700000000.000001000"]
    assert rows[4][:2] == ["mb", "tcp:1"]
    assert rows[-1][:2] == ["com1", "modem"]


def test_tshark_decodes_canopen_in_it(capture: Path) -> None:
    fields = output("tshark", "-r", str(capture), "-d", "can.subdissector,canopen", "-Y", "canopen.sdo.main_idx")
    assert "SDO" in fields


def test_tshark_decodes_modbus_with_nothing_to_complain_of(capture: Path) -> None:
    packets = tshark(capture, "-Y", "modbus", "-o", "tcp.check_checksum:TRUE", "-o", "ip.check_checksum:TRUE")
    assert [packet["mbtcp"]["mbtcp.trans_id"] for packet in packets] == ["7", "7", "8", "8"]
    assert {packet["tcp"]["tcp.checksum.status"] for packet in packets} == {"1"}
    assert {packet["ip"]["ip.checksum.status"] for packet in packets} == {"1"}
    ask, answer, _, refusal = (packet["modbus"] for packet in packets)
    assert (ask["modbus.func_code"], ask["modbus.reference_num"], ask["modbus.word_cnt"]) == ("3", "107", "3")
    assert answer["modbus.byte_cnt"] == "6"
    assert "modbus.request_frame" in answer  # matched with its request
    assert refusal["modbus.exception_code"] == "2"
    assert output("tshark", "-r", str(capture), "-Y", "_ws.malformed || tcp.analysis.flags || tcp.len == 0") == ""


def test_capture_that_wireshark_has_saved_again_is_read(capture: Path, tmp_path: Path) -> None:
    again = tmp_path / "again.pcapng"
    output("tshark", "-r", str(capture), "-w", str(again), "-F", "pcapng")
    with again.open("rb") as file:
        assert [(entry.bus, entry.family, entry.sender, entry.data) for entry in pcapng.read(file)] == [
            (entry.bus, entry.family, entry.sender, entry.data) for entry in ENTRIES
        ]


def test_tshark_decodes_a_call_down_to_http(tmp_path: Path) -> None:
    """A call of `fieldrig dial` on a serial line: modem, LCP, PAP, IPCP, TCP, and a page."""
    bench = Bench()
    bench.run(20, lambda: bench.caller.is_up)
    connection, page = bench.caller.open(80), bytearray()
    connection.on_data = page.extend
    connection.send(b"GET /INDEX.HTM HTTP/1.0\r\n\r\n")
    connection.end()
    bench.run(20, lambda: page == PAGE)
    bench.run(1)
    bench.caller.hang_up(bench.now_ns)
    bench.run(10)
    path = tmp_path / "call.pcapng"
    with path.open("wb") as file:
        entries = [TraceEntry(time_ns, "com1", "serial", name, b"\x00" + data) for time_ns, name, data in bench.line]
        assert pcapng.write(entries, file, START_UNIX_NS) == len(entries)
    checks = ("-o", "tcp.check_checksum:TRUE", "-o", "ip.check_checksum:TRUE")
    assert output("tshark", "-r", str(path), *checks, "-Y", "_ws.malformed || ip.checksum.status == 0") == ""
    assert output("tshark", "-r", str(path), *checks, "-Y", "tcp.checksum.status == 0 || tcp.analysis.flags") == ""
    found = output("tshark", "-r", str(path), "-Y", "ppp", "-T", "fields", "-e", "_ws.col.Protocol").split()
    assert {"LCP", "PAP", "IPCP", "TCP", "HTTP"} <= {name.removeprefix("PPP").strip() for name in found}
    (request,) = tshark(path, "-Y", "http.request")
    (response,) = tshark(path, "-Y", "http.response")
    assert "/INDEX.HTM" in json.dumps(request["http"])
    assert response["http"]["http.content_length_header"] == "50000"
    assert request["frame"]["frame.interface_id_tree"]["frame.interface_name"] == "com1 PPP"
    with path.open("rb") as file:
        assert [(entry.time_ns, entry.sender, entry.data) for entry in pcapng.read(file)] == [
            (entry.time_ns, entry.sender, entry.data) for entry in entries
        ]


def test_log2asc_reads_the_log(log: Path) -> None:
    lines = output("log2asc", "-I", str(log), "can0").splitlines()
    assert any("605" in line and "40 00 10 00 00 00 00 00" in line for line in lines)
    assert any("1ABCDEF0x" in line for line in lines)


def test_python_can_reads_the_log(log: Path) -> None:
    messages = list(can.LogReader(log))
    assert [message.arbitration_id for message in messages] == [frame.identifier for frame in CAN]
    assert messages[2].is_remote_frame
    assert messages[2].dlc == 4
    assert messages[3].is_fd
    assert messages[3].bitrate_switch


def test_asc2log_reads_our_asc_and_we_read_that_of_log2asc(tmp_path: Path) -> None:
    """Time stamps of asc2log count from the instant at which it runs, because it knows other forms of a date."""
    ours = tmp_path / "ours.asc"
    entries = [entry._replace(bus=f"can{number % 2}") for number, entry in enumerate(ENTRIES[: len(CAN)])]
    with ours.open("wb") as file:
        assert asc.write(entries, file, START_UNIX_NS) == len(CAN)
    bodies = [line.split()[1:3] for line in output("asc2log", "-I", str(ours)).splitlines() if "#" in line]
    assert bodies == [
        ["can0", "605#4000100000000000"],
        ["can1", "1ABCDEF0#0102"],
        ["can0", "123#R4"],
        ["can1", "124##1000102030405060708090A0B"],
    ]
    log = tmp_path / "ours.log"
    with log.open("wb") as file:
        candump.write(entries, file, START_UNIX_NS)
    theirs = output("log2asc", "-I", str(log), "can0", "can1").encode()
    assert [(entry.bus, entry.data) for entry in asc.read(io.BytesIO(theirs))] == [
        (entry.bus, entry.data) for entry in entries
    ]


def test_tshark_reads_our_pcap(tmp_path: Path) -> None:
    with (tmp_path / "can.pcap").open("wb") as file:
        assert pcap.write(ENTRIES, file, START_UNIX_NS) == len(CAN)
    with (tmp_path / "modbus.pcap").open("wb") as file:
        assert pcap.write(ENTRIES[len(CAN) :], file, START_UNIX_NS) == len(MODBUS)
    assert len(tshark(tmp_path / "can.pcap", "-Y", "can || canfd")) == len(CAN)
    fields = output(
        "tshark", "-r", str(tmp_path / "modbus.pcap"), "-Y", "modbus", "-T", "fields", "-e", "frame.time_epoch"
    )
    assert fields.split() == [f"1700000000.00000{n}000" for n in range(len(MODBUS))]


def test_a_capture_that_tshark_has_saved_as_classic_pcap_is_read(tmp_path: Path) -> None:
    """It knows the transaction on the line, and nothing of the exchange inside the rig."""
    ours, other = tmp_path / "modbus.pcapng", tmp_path / "modbus.pcap"
    with ours.open("wb") as file:
        pcapng.write(ENTRIES[len(CAN) : -1], file, START_UNIX_NS)
    output("tshark", "-r", str(ours), "-F", "nsecpcap", "-w", str(other))
    with other.open("rb") as file:
        found = [modbus_codec.decode(entry.data) for entry in pcap.read(file)]
    assert [(type(one), one.unit, one.pdu) for one in found if isinstance(one, ModbusRequest | ModbusResponse)] == [
        (type(message), message.unit, message.pdu) for _, message in MODBUS
    ]
