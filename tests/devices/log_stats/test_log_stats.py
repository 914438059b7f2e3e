"""`fieldrig trace stats`: figures of small logs, which can be counted by hand."""

import json
from operator import attrgetter
from pathlib import Path
from typing import Any

import pytest
from canopen_bench import EDS, IO32
from hypothesis import given, settings
from hypothesis import strategies as st
from logs import can_entry, can_log, modbus_log
from typer.testing import CliRunner

from fieldrig.cli.trace import app
from fieldrig.clock import MS
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.can.frame import CanFrame
from fieldrig_bus.modbus.codec import encode
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.log_stats.can_stats import MOST_IDENTIFIERS
from fieldrig_devices.log_stats.log_stats import LogStats
from fieldrig_devices.log_stats.report import as_data
from fieldrig_devices.named_logs.named_log import NamedLog

READ = ("605#40 00 10 00 00 00 00 00", "585#43 00 10 00 91 01 0F 00")
REFUSED = ("605#40 00 63 00 00 00 00 00", "585#80 00 63 00 00 00 02 06")
EMERGENCY = "085#30 81 11 00 00 00 00 00"


DESCRIBED, PLAIN = NamedLog({5: IO32}), NamedLog()


def figures(entries: list[TraceEntry], bitrate: int | None = None, names: NamedLog = DESCRIBED) -> Any:
    stats = LogStats(names, bitrate)
    stats.read(entries)
    return as_data(stats)


def bus(*frames: str) -> Any:
    (found,) = figures(can_log(*frames))["buses"]
    return found


def test_identifiers_have_counts_periods_and_names() -> None:
    entries = [can_entry(at * MS, CanFrame(0x185, bytes(4))) for at in (0, 10, 20, 31)]
    (can,) = figures([*entries, can_entry(40 * MS, CanFrame(0x18FEF100, b"\x01", is_extended=True))])["buses"]
    pdo, foreign = can["identifiers"]
    assert (pdo["identifier"], pdo["service"], pdo["node"], pdo["count"], pdo["bytes"]) == (
        0x185,
        "TPDO 1",
        "node 5",
        4,
        16,
    )
    assert (pdo["period_ns"], pdo["jitter_ns"]) == (10 * MS, MS)
    assert (foreign["identifier"], foreign["is_extended"], foreign["service"]) == (0x18FEF100, True, "")


def test_nodes_have_transfers_answer_times_and_errors() -> None:
    (node,) = bus(*READ, *REFUSED, READ[0], EMERGENCY, "705#00")["nodes"]
    assert (node["node_id"], node["name"], node["boot_ups"]) == (5, "node 5", 1)
    assert (node["sdo"]["reads"], node["sdo"]["unanswered"]) == (3, 1)
    assert node["sdo"]["errors"] == {"0602 0000h no object": 1}
    assert (node["sdo"]["answer_times"]["p50_ns"], node["sdo"]["answer_times"]["count"]) == (MS, 2)
    (emergency,) = node["emergencies"]
    assert emergency.startswith("8130h life guard or heartbeat error")


def test_heartbeats_that_stay_out_are_counted() -> None:
    beats = [can_entry(at * 100 * MS, CanFrame(0x705, b"\x05")) for at in (0, 1, 2, 3, 4, 20, 21)]
    (can,) = figures(beats)["buses"]
    assert can["nodes"][0]["heartbeats_missing"] == 1


def test_the_load_is_that_of_the_bits_on_the_wire() -> None:
    """55h in all bytes has no stuff bits but those of the CRC; 8 data bytes and 11 bits are at least 111 bits."""
    frame = CanFrame(0x555, b"\x55" * 8)
    (can,) = figures([can_entry(at * MS, frame) for at in range(1000)], 125_000)["buses"]
    (second,) = can["load_by_second"]
    assert 111 / 125 <= second["load"] <= 135 / 125
    assert second["load"] == pytest.approx(can["load"], rel=0.01)
    (halved,) = figures([can_entry(at * MS, frame) for at in range(1000)], 250_000)["buses"]
    assert halved["load"] == pytest.approx(can["load"] / 2)


def test_units_have_requests_answer_times_and_exceptions() -> None:
    log = modbus_log(
        [
            ("a", ModbusRequest(1, b"\x03\x00\x00\x00\x01")), ("m", ModbusResponse(1, b"\x03\x02\x00\x01")),
            ("a", ModbusRequest(1, b"\x06\x00\x00\x00\x01")), ("m", ModbusResponse(1, b"\x86\x02")),
            ("a", ModbusRequest(2, b"\x03\x00\x00\x00\x01")), ("m", ModbusResponse(9, b"\x03\x02\x00\x01")),
        ]
    )  # fmt: skip
    (modbus,) = figures(log)["buses"]
    first, second, ninth = modbus["units"]
    assert (first["unit"], first["reads"], first["writes"]) == (1, 1, 1)
    assert first["errors"] == {"write register: 02h illegal data address": 1}
    assert (first["answer_times"]["p99_ns"], first["requests"]["period_ns"]) == (MS, 2 * MS)
    assert (second["unanswered"], ninth["strays"]) == (1, 1)


def test_servers_of_a_network_have_units_of_their_own() -> None:
    """Two connections with the same transactions; the exchange has the number of the connection above them."""
    ask, value = b"\x03\x00\x00\x00\x01", b"\x03\x02\x00\x01"
    log = modbus_log(
        [
            ("10.0.0.1:4001", ModbusRequest(1, ask, 5)), ("10.0.0.1:4002", ModbusRequest(1, ask, 0x1_0005)),
            ("10.0.0.3:502", ModbusResponse(1, value, 0x1_0005)), ("10.0.0.2:502", ModbusResponse(1, value, 5)),
            ("10.0.0.1:4002", ModbusRequest(1, ask, 0x1_0006)),
        ]
    )  # fmt: skip
    (modbus,) = figures(log)["buses"]
    times = [(unit["server"], unit["answer_times"]["max_ns"], unit["unanswered"]) for unit in modbus["units"]]
    assert times == [("10.0.0.2:502", 3 * MS, 0), ("10.0.0.3:502", MS, 1)]


def test_the_period_of_requests_is_that_of_asking_whenever_the_answers_come() -> None:
    """A request without an answer ends with the log, and answers of one client overtake those of the other."""
    ask, value = b"\x03\x00\x00\x00\x01", b"\x03\x02\x00\x01"
    log: list[TraceEntry] = []
    for number in range(20):
        at_ns, exchange, has_early_answer = number * 10 * MS, number % 2 << 16 | number, number % 2 == 0 or number == 1
        request = encode(ModbusRequest(1, ask, exchange))
        log.append(TraceEntry(at_ns, "mb", "modbus", f"10.0.0.1:400{number % 2}", request))
        if number % 5 != 3:
            answered_ns = at_ns + (4 if has_early_answer else 17) * MS
            response = encode(ModbusResponse(1, value, exchange))
            log.append(TraceEntry(answered_ns, "mb", "modbus", "10.0.0.2:502", response))
    log.sort(key=attrgetter("time_ns"))
    (modbus,) = figures(log)["buses"]
    (unit,) = modbus["units"]
    assert (unit["requests"]["count"], unit["reads"], unit["unanswered"]) == (20, 20, 4)
    assert (unit["requests"]["period_ns"], unit["requests"]["jitter_ns"]) == (10 * MS, 0)


def test_a_million_identifiers_take_no_more_memory_than_many() -> None:
    entries = [can_entry(0, CanFrame(number, b"", is_extended=True)) for number in range(MOST_IDENTIFIERS + 100)]
    (can,) = figures(entries)["buses"]
    assert (len(can["identifiers"]), can["other_identifiers"], can["count"]) == (MOST_IDENTIFIERS, 100, len(entries))


@settings(max_examples=40, deadline=None)
@given(
    st.lists(
        st.builds(
            TraceEntry,
            st.integers(-(10**12), 2**62),
            st.sampled_from(["a", "b"]),
            st.sampled_from(["can", "modbus", "wires", "unheard"]),
            st.just("x"),
            st.binary(max_size=16),
        ),
        max_size=30,
    )
)
def test_any_log_has_figures(entries: list[TraceEntry]) -> None:
    data = figures(entries, names=PLAIN)
    assert data["count"] == len(entries) == sum(found["count"] for found in data["buses"])
    json.dumps(data)


@pytest.fixture
def log(tmp_path: Path) -> Path:
    path = tmp_path / "log.jsonl"
    write([*can_log(*READ, EMERGENCY), *modbus_log([("a", ModbusRequest(1, b"\x03\x00\x00\x00\x01"))])], path)
    return path


def test_the_command_prints_tables_or_json(log: Path) -> None:
    shown = CliRunner().invoke(app, ["stats", str(log), "--eds", f"5={IO32}"], catch_exceptions=False)
    assert shown.exit_code == 0
    for words in (
        "4 messages",
        "at 250 kbit/s (assumed; --bitrate)",
        "605  SDO request  node 5",
        "EMCY 8130h",
        "unit 1",
    ):
        assert words in shown.output
    data = json.loads(CliRunner().invoke(app, ["stats", str(log), "--json", "--bitrate", "500000"]).output)
    assert (data["bitrate"], data["is_bitrate_assumed"], data["count"]) == (500_000, False, 4)


def test_a_row_names_few_kinds_of_errors(tmp_path: Path) -> None:
    path = tmp_path / "log.jsonl"
    write(can_log(*(f"085#{number:02X}81110000000000" for number in range(40))), path)
    shown = CliRunner().invoke(app, ["stats", str(path)], catch_exceptions=False).output
    assert "36 more kinds; --json has all" in shown
    assert max(map(len, shown.splitlines())) < 600
    data = json.loads(CliRunner().invoke(app, ["stats", str(path), "--json"]).output)
    assert json.dumps(data).count("8120h") == 1, "scripts get all"


def test_the_bit_rate_is_that_of_the_rig(log: Path) -> None:
    data = json.loads(
        CliRunner().invoke(app, ["stats", str(log), "--json", "--rig", str(EDS.parent / "lab.yaml")]).output
    )
    assert (data["bitrate"], data["is_bitrate_assumed"]) == (250_000, False)


def test_a_part_without_messages_says_so(log: Path) -> None:
    assert CliRunner().invoke(app, ["stats", str(log), "--from", "60min"]).stdout == "no messages\n"
