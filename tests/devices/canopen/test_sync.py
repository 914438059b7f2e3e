"""SYNC, CiA 301 7.2.5."""

import re
from pathlib import Path

import pytest
from canopen_bench import IO32, CanopenBench

PRODUCE_EVERY_10_MS = ("23 06 10 00 10 27 00 00", "23 05 10 00 80 00 00 40")


def test_producer_keeps_its_period_and_hears_itself(bench: CanopenBench) -> None:
    bench.write("2f 00 18 02 01 00 00 00")
    bench.write(*PRODUCE_EVERY_10_MS)
    assert bench.after(10) == ["080#"]
    bench.send("000#01 05")
    assert bench.after(20) == ["080#", "185#00 00 00 00"] * 2


def test_producer_counts(bench: CanopenBench) -> None:
    bench.write("2f 19 10 00 03 00 00 00", *PRODUCE_EVERY_10_MS)
    assert bench.after(40) == ["080#01", "080#02", "080#03", "080#01"]


def test_stopped_producer_is_silent_and_counts_anew(bench: CanopenBench) -> None:
    bench.write("2f 19 10 00 03 00 00 00", *PRODUCE_EVERY_10_MS)
    bench.after(20)
    assert bench.send("000#02 05") == []
    assert bench.after(100) == []
    bench.send("000#80 05")
    assert bench.after(10) == ["080#01"]


@pytest.mark.parametrize("stop", [("23 05 10 00 80 00 00 00",), ("23 06 10 00 00 00 00 00",)])
def test_producer_that_was_stopped_by_its_objects_counts_anew(bench: CanopenBench, stop: tuple[str, ...]) -> None:
    """CiA's log of such a producer begins with 1 again (7.2.5.2.1)."""
    bench.write("2f 19 10 00 0a 00 00 00", *PRODUCE_EVERY_10_MS)
    assert bench.after(20)[-1] == "080#02"
    bench.write(*stop, "23 06 10 00 00 00 00 00", "2f 19 10 00 05 00 00 00")
    bench.write("23 05 10 00 80 00 00 00", *PRODUCE_EVERY_10_MS)
    assert bench.after(20) == ["080#01", "080#02"]


def test_another_period_does_not_disturb_the_counter(bench: CanopenBench) -> None:
    bench.write("2f 19 10 00 0a 00 00 00", *PRODUCE_EVERY_10_MS)
    bench.after(20)
    bench.write("23 06 10 00 20 4e 00 00")
    assert bench.after(20) == ["080#03"]


def test_period_0_ends_it(bench: CanopenBench) -> None:
    bench.write(*PRODUCE_EVERY_10_MS)
    bench.write("23 06 10 00 00 00 00 00")
    assert bench.after(100) == []


def test_refused_changes(bench: CanopenBench) -> None:
    bench.play(
        [
            ("2f 19 10 00 01 00 00 00", "80 19 10 00 30 00 09 06"),
            ("2f 19 10 00 f1 00 00 00", "80 19 10 00 30 00 09 06"),
            ("23 06 10 00 10 27 00 00", "60 06 10 00 00 00 00 00"),
            ("2f 19 10 00 0a 00 00 00", "80 19 10 00 22 00 00 08"),
            ("23 05 10 00 00 00 00 00", "80 05 10 00 30 00 09 06"),
            ("23 05 10 00 80 00 00 40", "60 05 10 00 00 00 00 00"),
            ("23 05 10 00 81 00 00 40", "80 05 10 00 22 00 00 08"),
            ("23 05 10 00 81 00 00 00", "60 05 10 00 00 00 00 00"),
        ]
    )
    assert 0x081 in bench.interest
    assert 0x080 not in bench.interest


def test_sync_of_another_length_is_reported_and_not_taken(bench: CanopenBench) -> None:
    bench.write("2f 00 18 02 01 00 00 00")
    bench.send("000#01 05")
    assert bench.send("080#01") == ["085#40 82 11 01 00 00 00 00"]
    assert bench.send("080#02") == []
    assert bench.send("080#") == ["085#00 00 00 00 00 00 00 00", "185#00 00 00 00"]


def test_synchronous_pdos_without_1005h_follow_the_usual_sync(tmp_path: Path) -> None:
    """CiA 301 7.5.2.5: its default is 80h.  Public files of drives have synchronous PDOs and no 1005h."""
    text = IO32.read_text(encoding="utf-8")
    for index in ("1005", "1006", "1007", "1019"):
        text = re.sub(rf"(?ms)^\[{index}\]$.*?(?=^\[)", "", re.sub(rf"(?m)^(\d+)=0x{index}$", r"\1=0x1003", text))
    eds = tmp_path / "thin.eds"
    eds.write_text(text, encoding="utf-8")
    bench = CanopenBench(eds)
    assert bench.sdo("40 05 10 00 00 00 00 00") == "80 05 10 00 00 00 02 06"
    bench.send("000#01 05")
    assert bench.send("080#") == []
    assert not any(frame.startswith("085") for frame in bench.send("080#01")), "nothing here hears a SYNC"
    bench.write("2f 00 18 02 01 00 00 00")
    assert bench.send("080#") == ["185#00 00 00 00"]
    bench.write("2f 00 18 02 ff 00 00 00")
    assert bench.send("080#") == []
