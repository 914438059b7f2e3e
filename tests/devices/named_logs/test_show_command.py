"""`fieldrig trace show` with the files of nodes and units, and with filters."""

import json
from contextlib import suppress
from pathlib import Path

import pytest
from canopen_bench import EDS, IO32
from hypothesis import given
from hypothesis import strategies as st
from logs import can_log, modbus_log
from typer.testing import CliRunner

from fieldrig.cli.trace import app
from fieldrig.clock import MS, S
from fieldrig.errors import ConfigError, UsageError
from fieldrig.traces.trace import TraceEntry
from fieldrig.traces.trace_files import write
from fieldrig_bus.modbus.message import ModbusRequest, ModbusResponse
from fieldrig_devices.named_logs.filters import identifiers_of, register_range

TABLE = EDS.parent / "registers" / "pump-drive.yaml"
LEVEL, VALUE = bytes.fromhex("04 00 00 00 01"), bytes.fromhex("04 02 01 F4")
COIL, ILLEGAL = bytes.fromhex("05 00 00 FF 00"), b"\x85\x01"
FRAMES = (
    "000#01 00", "080#", "705#05", "706#05", "185#01 02 03 04", "186#01", "085#00 10 01 00 00 00 00 00",
    "605#40 00 10 00 00 00 00 00", "585#43 00 10 00 91 01 0F 00", "1ABCDEF0#01",
)  # fmt: skip


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("log") / "machine.jsonl"
    modbus = modbus_log(
        [
            ("a", ModbusRequest(1, LEVEL)),
            ("drive", ModbusResponse(1, VALUE)),
            ("a", ModbusRequest(2, COIL)),
            ("drive", ModbusResponse(2, ILLEGAL)),
        ]
    )
    later = [entry._replace(time_ns=entry.time_ns + S) for entry in modbus]
    write([*can_log(*FRAMES), *later], path)
    return path


def shown(log: Path, *arguments: str) -> list[str]:
    result = CliRunner().invoke(app, ["show", str(log), *arguments], catch_exceptions=False)
    assert result.exit_code == 0, result.output
    return [line.rsplit("  ", 1)[-1].strip() for line in result.output.splitlines()]


def kinds(log: Path, *arguments: str) -> list[str]:
    return [json.loads(line)["kind"] for line in _json(log, *arguments)]


def _json(log: Path, *arguments: str) -> list[str]:
    return CliRunner().invoke(app, ["show", str(log), "--json", *arguments], catch_exceptions=False).output.splitlines()


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (("--node", "5"), ["heartbeat", "TPDO 1", "EMCY", "SDO read"]),
        (("--node", "5", "--frames", "--service", "sdo"), ["SDO read", "SDO value"]),
        (("--node", "5", "--node", "6", "--service", "heartbeat"), ["heartbeat", "heartbeat"]),
        (("--node", "node 6"), ["heartbeat", "TPDO 1"]),
        (("--id", "0x185"), ["TPDO 1"]),
        (("--id", "389"), ["TPDO 1"]),
        (("--id", "0x180-0x1FF"), ["TPDO 1", "TPDO 1"]),
        (("--id", "0x700/0x780"), ["heartbeat", "heartbeat"]),
        (("--id", "0x1ABCDEF0"), [""]),
        (("--id", "0x605"), ["SDO read"]),
        (("--id", "0x585"), ["SDO read"]),
        (("--unit", "1"), ["read input registers"]),
        (("--unit", "2", "--node", "6"), ["heartbeat", "TPDO 1", "write coil"]),
        (("--register", "30001"), ["read input registers"]),
        (("--register", "input:0-9"), ["read input registers"]),
        (("--register", "40001-40100"), []),
        (("--register", "1"), ["write coil"]),
        (("--registers", f"1={TABLE}", "--register", "level"), ["read input registers"]),
        (("--registers", f"1={TABLE}", "--register", "ru*"), []),
        (("--service", "sdo"), ["SDO read"]),
        (("--service", "pdo"), ["TPDO 1", "TPDO 1"]),
        (("--service", "nmt", "--service", "sync"), ["NMT", "SYNC"]),
        (("--service", "read"), ["SDO read", "read input registers"]),
        (("--service", "exception"), ["write coil"]),
        (("can0", "--service", "write"), []),
    ],
)
def test_filters_choose_rows(log: Path, arguments: tuple[str, ...], expected: list[str]) -> None:
    assert kinds(log, *arguments) == expected


def test_files_give_names_without_a_rig(log: Path) -> None:
    found = shown(log, "--eds", f"5={IO32}", "--registers", f"1={TABLE}", "--service", "pdo", "--service", "read")
    assert any("Read inputs byte 1 1, Read inputs byte 2 2" in line for line in found)
    assert any("level 0.5 m" in line for line in found)


def test_a_rig_gives_names_of_nodes_and_registers_to_filters(log: Path) -> None:
    lab = ("--rig", str(EDS.parent / "lab.yaml"))
    assert kinds(log, *lab, "--node", "io") == ["heartbeat", "TPDO 1", "EMCY", "SDO read"]
    assert kinds(log, *lab, "--register", "level") == ["read input registers"]
    with pytest.raises(UsageError, match="did you mean sensor"):
        shown(log, *lab, "--node", "sensr")


def test_an_eds_may_be_that_of_one_bus(tmp_path: Path) -> None:
    path = tmp_path / "two.jsonl"
    write([*can_log("185#01 02 03 04"), *can_log("185#01 02 03 04", bus="can1")], path)
    assert shown(path, "--eds", f"can1:5={IO32}", "--service", "tpdo") == [
        "TPDO 1 node 5 01 02 03 04",
        "TPDO 1 node 5 Read inputs byte 1 1, Read inputs byte 2 2, Read inputs byte 3 3, Read inputs byte 4 4",
    ]


MAPPED = (
    "605#2F 00 1A 00 00 00 00 00", "585#60 00 1A 00 00 00 00 00",
    "605#23 00 1A 01 10 01 01 64", "585#60 00 1A 01 00 00 00 00",
    "605#2F 00 1A 00 01 00 00 00", "585#60 00 1A 00 00 00 00 00",
)  # fmt: skip


def test_a_part_of_a_log_knows_the_mapping_before_it_if_wanted(tmp_path: Path) -> None:
    path = tmp_path / "mapped.jsonl"
    write(can_log(*MAPPED, "185#18 FC"), path)
    part = ("--eds", f"5={IO32}", "--from", "6ms")
    assert shown(path, *part, "--learn") == ["TPDO 1 node 5 Analogue input 1 -1000"]
    assert shown(path, *part) == [
        "TPDO 1 node 5 Read inputs byte 1 24 (18h), Read inputs byte 2 252 (FCh), too short for its mapping"
    ]


def test_json_has_the_numbers_of_a_dialogue(log: Path) -> None:
    (sdo,) = map(json.loads, _json(log, "--service", "sdo"))
    assert (sdo["index"], sdo["subindex"], sdo["data"], sdo["abort"]) == (0x1000, 0, "91010f00", None)
    assert (sdo["entries"], sdo["duration_ns"], sdo["node_ids"]) == ([7, 8], 1_000_000, [5])
    level, coil = map(json.loads, _json(log, "--service", "modbus", "--registers", f"1={TABLE}"))
    assert level["values"] == [{"name": "level", "value": 0.5, "text": "0.5 m"}]
    assert (coil["exception"], coil["unit"], coil["is_done"]) == (1, 2, True)


def test_json_has_the_values_of_frames(log: Path) -> None:
    pdo, _ = map(json.loads, _json(log, "--service", "pdo", "--eds", f"5={IO32}"))
    assert [(value["key"], value["name"], value["value"]) for value in pdo["values"]][:2] == [
        ("6000h:01", "Read inputs byte 1", 1),
        ("6000h:02", "Read inputs byte 2", 2),
    ]
    (emergency,) = map(json.loads, _json(log, "--service", "emcy"))
    assert emergency["values"][0]["value"] == 0x1000


def test_registers_may_be_a_list_in_csv(log: Path, tmp_path: Path) -> None:
    listed = tmp_path / "meter.csv"
    listed.write_text("address,name,type,register type,unit,scale\n0,level,u16,input register,m,0.001\n")
    (line,) = shown(log, "--registers", f"1={listed}", "--register", "level")
    assert line == "read input registers unit 1 level 0.5 m, in 1 ms"
    wrong = tmp_path / "wrong.csv"
    wrong.write_text("x,y\n1,2\n")
    with pytest.raises(UsageError, match="is no list of registers"):
        shown(log, "--registers", f"1={wrong}")


def test_every_frame_has_a_line_if_wanted(log: Path) -> None:
    assert len(shown(log, "--frames")) == len(FRAMES) + 4 == len(shown(log)) + 3


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--service", "hearbeat"), "did you mean heartbeat?"),
        (("--node", "200"), "expected a number up to 127"),
        (("--unit", "one"), "expected a number up to 255"),
        (("--id", "18Z"), "expected such as 0x181"),
        (("--id", "0x3FFFFFFFF"), "at most 1FFFFFFFh"),
        (("--id", "0x200-0x100"), "the last identifier is below the first"),
        (("--register", "90001"), "expected such as 40001"),
        (("--register", "holdin:1"), "did you mean holding?"),
        (("--register", "level"), "a name needs --registers"),
        (("--registers", f"1={TABLE}", "--register", "levl"), "did you mean level"),
        (("--eds", "io32.eds"), "not NUMBER=FILE"),
        (("--eds", f"0={IO32}"), "expected 1 to 127"),
        (("--eds", f"5={IO32}", "--eds", f"5={IO32}"), "already has the file"),
        (("--registers", f"256={TABLE}"), "expected 0 to 255"),
    ],
)
def test_a_wrong_option_is_refused_with_what_was_expected(log: Path, arguments: tuple[str, ...], said: str) -> None:
    result = CliRunner().invoke(app, ["show", str(log), *arguments])
    assert result.exit_code == 2
    assert said in " ".join(result.output.replace("│", " ").split())


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (("--node", "9"), "the log has no messages of node 9\n  there are: 5, node 5, 6, node 6"),
        (("--node", "nod 5"), "did you mean node 5?"),
        (("--unit", "3"), "the log has no messages of unit 3\n  there are: 1, 2"),
    ],
)
def test_what_the_log_does_not_have_is_told_with_what_it_has(log: Path, arguments: tuple[str, ...], said: str) -> None:
    with pytest.raises(UsageError, match="the log has no messages") as caught:
        CliRunner().invoke(app, ["show", str(log), *arguments], catch_exceptions=False)
    assert said in str(caught.value)


def test_a_wrong_file_is_told_with_its_line(log: Path, tmp_path: Path) -> None:
    eds, table = tmp_path / "no.eds", tmp_path / "no.yaml"
    eds.write_text("[DeviceInfo]\n[2000]\nParameterName=x\n")
    table.write_text("holding_registers:\n  - {address: 0, name: level, tpe: u16}\n")
    with pytest.raises(ConfigError) as caught:
        shown(log, "--eds", f"5={eds}")
    assert str(eds) in str(caught.value)
    with pytest.raises(ConfigError, match=r"no\.yaml:2"):
        shown(log, "--registers", f"1={table}")
    with pytest.raises(UsageError, match="cannot be read") as missing:
        shown(log, "--eds", f"5={IO32.with_name('io23.eds')}")
    assert "did you mean" in str(missing.value)


@given(st.text(max_size=12))
def test_any_word_is_an_identifier_or_a_register_or_refused(word: str) -> None:
    for read in (identifiers_of, register_range):
        with suppress(ValueError):
            read(word)


def test_control_characters_of_a_device_do_not_reach_the_terminal(tmp_path: Path) -> None:
    """The device name is ESC [ 2 J, which would clear the screen."""
    path = tmp_path / "name.jsonl"
    write(can_log("605#40 08 10 00 00 00 00 00", "585#43 08 10 00 1B 5B 32 4A"), path)
    (line,) = shown(path)
    assert r"= \x1b[2J," in line


def test_a_long_content_is_cut_for_people_and_whole_for_scripts(tmp_path: Path) -> None:
    path = tmp_path / "long.jsonl"
    segments = [frame for number in range(30) for frame in (
        f"605#{0x60 | number % 2 << 4:02X} 00 00 00 00 00 00 00",
        f"585#{number % 2 << 4 | (number == 29):02X} 41 41 41 41 41 41 41",
    )]  # fmt: skip
    write(can_log("605#40 00 20 00 00 00 00 00", "585#41 00 20 00 D2 00 00 00", *segments), path)
    (line,) = shown(path)
    assert "41 41 …, 210 bytes in segments in 61 ms" in line
    assert json.loads(_json(path)[0])["data"] == "41" * 210


def test_a_serial_capture_of_modbus_is_shown_by_requests(tmp_path: Path) -> None:
    path = tmp_path / "line.jsonl"
    frames = [bytes.fromhex("11 03 00 6B 00 03 76 87"), bytes.fromhex("11 03 06 AE 41 56 52 43 40 49 AD")]
    write([TraceEntry(number * MS, "tty", "serial", "", b"\x00" + frame) for number, frame in enumerate(frames)], path)
    assert shown(path) == ["read holding registers unit 17 107-109 = AE41h 5652h 4340h, in 1 ms"]
