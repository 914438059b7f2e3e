"""The markers of the program on Modbus: bytes of requests and answers, and the values that the program sees."""

from pathlib import Path

import pytest
from max4_faces_bench import FacesBench

PROGRAM = """
PROGRAM PLC_PRG
VAR
  low AT %MW0 : WORD := 16#1234;
  double AT %MD1 : DWORD := 16#11223344;
  flag AT %MX4.3 : BOOL;
  last AT %MW32767 : INT := -2;
  counted : INT;
END_VAR
IF flag THEN counted := counted + 1; END_IF
END_PROGRAM
"""


@pytest.fixture
def bench(tmp_path: Path) -> FacesBench:
    file = tmp_path / "markers.st"
    file.write_text(PROGRAM)
    return FacesBench("belt", program=str(file), autostart=True).boot(200)


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("03 80 00 00 01", "03 02 12 34"),  # %MW0
        ("04 80 02 00 02", "04 04 33 44 11 22"),  # %MD1: its low word first
        ("03 FF FF 00 01", "03 02 ff fe"),  # the last word
        ("06 80 00 AB CD", "06 80 00 ab cd"),
        ("10 80 02 00 02 04 00 01 00 02", "10 80 02 00 02"),
        ("05 80 43 FF 00", "05 80 43 ff 00"),  # %MX4.3 is bit 67
        ("0F 80 40 00 08 01 08", "0f 80 40 00 08"),
        ("01 80 43 00 01", "01 01 00"),
        ("03 FF FF 00 02", "83 02"),  # beyond the last word
        ("03 7F FF 00 02", "83 02"),  # begins below the markers
        ("01 FF FF 00 02", "81 02"),
        ("02 80 00 00 01", "82 02"),  # discrete inputs have no markers
    ],
)
def test_requests_and_answers(bench: FacesBench, request_: str, answer: str) -> None:
    assert bench.ask(request_) == answer


@pytest.mark.manual("PD-306")
def test_what_a_client_writes_the_program_sees(bench: FacesBench) -> None:
    runtime = bench.max4.firmware.plc.program.runtime  # type: ignore[union-attr]  # a program is loaded
    bench.ask("10 80 02 00 02 04 56 78 12 34")
    assert runtime.read(runtime.find("PLC_PRG.double")) == 0x12345678
    bench.ask("05 80 43 FF 00")
    bench.run(35)
    assert runtime.read(runtime.find("PLC_PRG.counted")) in (3, 4)
    assert bench.ask("01 80 43 00 01") == "01 01 01"


def test_a_reset_gives_the_markers_their_start_values(bench: FacesBench) -> None:
    bench.ask("10 80 00 00 02 04 AB CD AB CD")
    bench.set("command", "reset")
    bench.run(20)
    assert bench.ask("03 80 00 00 02") == "03 04 12 34 00 00"


def test_without_a_program_there_are_no_markers() -> None:
    bench = FacesBench("belt").boot()
    assert bench.ask("03 80 00 00 01") == "83 02"
    assert bench.ask("05 80 00 FF 00") == "85 02"
