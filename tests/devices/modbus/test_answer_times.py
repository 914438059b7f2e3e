"""The file of answer times of a Modbus device: rows in turn, by the narrowest kind of request that has some."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from fieldrig.clock import MS
from fieldrig_bus.modbus.message import ModbusRequest
from fieldrig_devices.modbus.answer_times import Answer, AnswerTimes, kind_of, read_answer_times
from fieldrig_devices.modbus.device import ModbusDeviceSettings

USUAL_NS = 7 * MS


def times_of(folder: Path, text: str) -> AnswerTimes:
    (folder / "times.csv").write_text(text)
    return AnswerTimes(read_answer_times(folder / "times.csv"), USUAL_NS)


def asked(times: AnswerTimes, *requests: str, unit: int = 1) -> list[float | None]:
    """Return the times in ms."""
    found = [times.next(ModbusRequest(unit, bytes.fromhex(pdu))).after_ns for pdu in requests]
    return [None if time_ns is None else time_ns / MS for time_ns in found]


def test_each_kind_has_its_rows_in_turn(tmp_path: Path) -> None:
    text = "function,address,quantity,answer_ms\n3,107,3,10\n3,107,3,20.5\n6,1,1,30\n3,5,,40\n4,,,50\n43,,,60\n"
    times = times_of(tmp_path, text)
    read = "03 006B 0003"
    assert asked(times, read, "06 0001 0003", read, read) == [10, 30, 20.5, 10]
    assert asked(times, "03 0005 0001", "03 0005 0009", "04 0000 0001", "2B 0E 01 00") == [40, 40, 50, 60]
    assert asked(times, "03 006B 0002", "07", "01", "") == [7, 7, 7, 7]


def test_a_row_may_be_of_one_unit_or_of_all_requests(tmp_path: Path) -> None:
    times = times_of(tmp_path, "unit;function;answer_ms\n2;3;1,5\n;3;2\n;;3\n")
    read = "03 0000 0001"
    assert asked(times, read, unit=2) + asked(times, read, "07", unit=3) == [1.5, 2, 3]


def test_a_row_without_a_time_is_a_request_that_is_lost(tmp_path: Path) -> None:
    text = "function,answer_ms\n3,10\n3,\n3,20\n"
    assert asked(times_of(tmp_path, text), "03 0000 0001", "03 0000 0001", "03 0000 0001") == [10, None, 20]


def test_a_row_with_an_exception_refuses(tmp_path: Path) -> None:
    times = times_of(tmp_path, "function,answer_ms,exception\n3,10,\n3,5,6\n3,,4\n")
    request = ModbusRequest(1, bytes.fromhex("03 0000 0001"))
    assert [times.next(request) for _ in range(3)] == [Answer(10 * MS), Answer(5 * MS, 6), Answer(None, 4)]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("function,answer_ms\n3,late\n", "line 2: expected 0 to 60000 in column 'answer_ms', got 'late'"),
        ("function,answer_ms\n3,1\n3,-1\n", "line 3: expected 0 to 60000"),
        ("function,answer_ms\n3,nan\n", "line 2: expected 0 to 60000"),
        ("function,answer_ms\n128,1\n", "line 2: expected 0 to 127 in column 'function', got '128'"),
        ("function,answer_ms\n3.5,1\n", "line 2: expected 0 to 127"),
        ("function,address,answer_ms\n,1,1\n", "line 2: expected a function where there is an address"),
        ("function,answer_ms,exception\n3,1,256\n", "line 2: expected 0 to 255 in column 'exception', got '256'"),
        ("function,answer\n3,1\n", "there is no column 'answer_ms'"),
        ("", "expected a line with the names of the columns"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "table.yaml").write_text("coils: [{address: 0, name: a}]")
    (tmp_path / "times.csv").write_text(text)
    keys = {"table": "table.yaml", "answer_times": "times.csv"}
    with pytest.raises(ValueError, match=r"(?s)answer_times.*times\.csv: ") as refused:
        ModbusDeviceSettings.model_validate(keys, context={"folder": tmp_path})
    assert words in str(refused.value)


@given(st.binary(min_size=1, max_size=12), st.integers(0, 255))
def test_every_request_has_a_time(pdu: bytes, unit: int) -> None:
    times = AnswerTimes({kind_of(unit, pdu): [Answer(1), Answer(2, 4)]}, USUAL_NS)
    found = [times.next(ModbusRequest(unit, pdu)) for _ in range(3)]
    assert found == [Answer(1), Answer(2, 4), Answer(1)]
