"""`modbus.device`: file records (functions 20 and 21), with the examples of V1.1b3, 6.14 and 6.15."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from register_bench import Bench

from fieldrig.errors import ConfigError
from fieldrig_devices.registers.table import load_table

FILES = """
files:
  - {number: 4, name: recipe, records: 200, initial: [0, 0x0DFE, 0x0020]}
  - {number: 3, name: log, records: 12, initial: [0, 0, 0, 0, 0, 0, 0, 0, 0, 0x33CD, 0x0040], access: ro}
"""


@pytest.fixture
def bench(tmp_path: Path) -> Bench:
    return Bench(tmp_path, FILES)


def test_two_groups_of_records_are_read_as_in_the_specification(bench: Bench) -> None:
    request = "14 0e 06 0004 0001 0002 06 0003 0009 0002"
    assert bench.ask(request) == "140c 0506 0dfe0020 0506 33cd0040".replace(" ", "")


def test_records_are_written_as_in_the_specification(bench: Bench) -> None:
    request = "15 0d 06 0004 0007 0003 06af 04be 100d"
    assert bench.ask(request) == request.replace(" ", "")
    assert bench.ask("14 07 06 0004 0006 0005") == "140c 0b06 0000 06af 04be 100d 0000".replace(" ", "")
    assert bench.point("recipe") == "00000dfe0020" + "0000" * 4 + "06af04be100d"


@pytest.mark.parametrize(
    ("request_pdu", "answer"),
    [
        ("14 07 07 0004 0000 0001", "9402"),  # another reference type
        ("14 07 06 0005 0000 0001", "9402"),  # no such file
        ("14 07 06 0004 00c7 0002", "9402"),  # beyond its last record
        ("14 07 06 0004 2710 0001", "9402"),  # record 10,000
        ("14 07 06 0004 0000 0000", "9403"),
        ("14 06 06 0004 0000 00", "9403"),
        ("14 08 06 0004 0000 0001 06", "9403"),
        ("14 09 06 0004 0000 0001", "9403"),
        ("14", "9403"),
        ("14 07 06 0004 0000 007c", "9403"),  # more than a response can carry
        ("15 09 06 0003 0000 0001 ffff", "9502"),  # read-only
        ("15 09 06 0004 0000 0002 ffff", "9503"),
        ("15 07 06 0004 0000 0000", "9503"),
    ],
)
def test_what_cannot_be_done_is_answered_as_the_specification_says(bench: Bench, request_pdu: str, answer: str) -> None:
    assert bench.ask(request_pdu) == answer


def test_a_request_is_executed_as_a_whole_or_not_at_all(bench: Bench) -> None:
    assert bench.ask("15 12 06 0004 0000 0001 aaaa 06 0003 0000 0001 bbbb") == "9502"
    assert bench.ask("14 07 06 0004 0000 0001") == "140403060000"


def test_a_device_without_files_does_not_know_the_functions(tmp_path: Path) -> None:
    bench = Bench(tmp_path, "coils: [{address: 0, name: a}]")
    assert bench.ask("14 07 06 0004 0000 0001") == "9401"
    assert bench.ask("15 09 06 0004 0000 0001 ffff") == "9501"


@given(st.binary(max_size=40), st.sampled_from([b"\x14", b"\x15"]))
def test_any_request_has_an_answer_of_its_function(
    tmp_path_factory: pytest.TempPathFactory, data: bytes, function: bytes
) -> None:
    answer = Bench(tmp_path_factory.getbasetemp(), FILES).ask((function + data).hex())
    assert answer is not None
    assert int(answer[:2], 16) & 0x7F == function[0]
    assert len(answer) <= 2 * 253


@pytest.mark.parametrize(
    "files",
    [
        "{number: 0, name: a}",
        "{number: 1, name: a, records: 10001}",
        "{number: 1, name: a, records: 1, initial: [1, 2]}",
        "{number: 1, name: a}, {number: 1, name: b}",
        "{number: 1, name: a}, {number: 2, name: a}",
    ],
)
def test_wrong_files_are_refused(tmp_path: Path, files: str) -> None:
    (tmp_path / "t.yaml").write_text(f"files: [{files}]")
    with pytest.raises(ConfigError):
        load_table(tmp_path / "t.yaml")
