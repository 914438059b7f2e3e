"""Node guarding and life guarding, CiA 301 7.2.8.2.2.1."""

import re
from pathlib import Path

import pytest
from canopen_bench import IO32, CanopenBench

GUARD = "705#R"
LIFE_TIME_OF_200_MS = ("2b 0c 10 00 64 00 00 00", "2f 0d 10 00 02 00 00 00")
LOST, FOUND = "085#30 81 11 00 00 00 00 00", "085#00 00 00 00 00 00 00 00"


def test_answer_has_the_state_and_a_bit_that_toggles(bench: CanopenBench) -> None:
    assert [bench.send(GUARD) for _ in range(3)] == [["705#7f"], ["705#ff"], ["705#7f"]]
    bench.send("000#02 05")
    assert [bench.send(GUARD) for _ in range(2)] == [["705#84"], ["705#04"]]


def test_toggle_bit_begins_anew_with_a_reset(bench: CanopenBench) -> None:
    bench.send(GUARD, "000#82 05")
    assert bench.send(GUARD) == ["705#7f"]


def test_heartbeat_goes_before_guarding(bench: CanopenBench) -> None:
    bench.write("2b 17 10 00 64 00 00 00")
    assert 0x705 not in bench.interest
    assert bench.send(GUARD) == []
    bench.write("2b 17 10 00 00 00 00 00")
    assert bench.send(GUARD) == ["705#7f"]


def test_master_that_no_longer_asks_is_reported_and_ends_operational(bench: CanopenBench) -> None:
    bench.write(*LIFE_TIME_OF_200_MS)
    bench.send("000#01 05")
    assert bench.after(1000) == []  # supervision starts with the first request
    bench.send(GUARD)
    assert bench.after(199) == []
    assert bench.after(1) == [LOST]
    assert bench.point("nmt.state") == "pre_operational"
    assert bench.after(1000) == []
    assert bench.send(GUARD) == ["705#ff", FOUND]


def test_each_request_gives_new_life(bench: CanopenBench) -> None:
    bench.write(*LIFE_TIME_OF_200_MS)
    for _ in range(5):
        bench.send(GUARD)
        assert bench.after(199) == []


@pytest.mark.parametrize("end", ["2b 0c 10 00 00 00 00 00", "2f 0d 10 00 00 00 00 00", "2b 17 10 00 e8 03 00 00"])
def test_life_time_of_0_and_heartbeat_end_the_watch(bench: CanopenBench, end: str) -> None:
    bench.write(*LIFE_TIME_OF_200_MS)
    bench.send(GUARD)
    bench.write(end)
    assert bench.after(500) == []


def test_end_of_the_watch_ends_its_error(bench: CanopenBench) -> None:
    bench.write(*LIFE_TIME_OF_200_MS)
    bench.send(GUARD)
    assert bench.after(200) == [LOST]
    assert FOUND in bench.send("605#2f 0d 10 00 00 00 00 00")


def test_another_life_time_counts_from_now(bench: CanopenBench) -> None:
    bench.write(*LIFE_TIME_OF_200_MS)
    bench.send(GUARD)
    bench.after(150)
    bench.write("2f 0d 10 00 03 00 00 00")
    assert bench.after(299) == []
    assert bench.after(1) == [LOST]


@pytest.mark.parametrize(("behaviour", "state"), [("00", "pre_operational"), ("01", "operational"), ("02", "stopped")])
def test_error_behaviour_says_what_a_lost_master_does(bench: CanopenBench, behaviour: str, state: str) -> None:
    bench.write(*LIFE_TIME_OF_200_MS, f"2f 29 10 01 {behaviour} 00 00 00")
    bench.send("000#01 05", GUARD)
    bench.after(200)
    assert bench.point("nmt.state") == state


def test_error_lasts_until_heartbeat_and_guarding_are_back(bench: CanopenBench) -> None:
    bench.write(*LIFE_TIME_OF_200_MS, "23 16 10 01 64 00 09 00")
    bench.send(GUARD, "709#05")
    assert bench.after(200) == [LOST]
    assert FOUND not in bench.send(GUARD)
    assert bench.send("709#05") == [FOUND]


@pytest.mark.parametrize("frame", ["705#7f", "705#", "706#R"])
def test_only_the_remote_frame_is_answered(bench: CanopenBench, frame: str) -> None:
    assert bench.send(frame) == []


@pytest.mark.parametrize("missing", ["100C", "100D"])
def test_without_guard_time_or_factor_there_is_no_life_time(tmp_path: Path, missing: str) -> None:
    """Requests are answered where there is a guard time; no time of silence is too long."""
    text = re.sub(rf"(?ms)^\[{missing}\]$.*?(?=^\[)", "", IO32.read_text(encoding="utf-8"))
    eds = tmp_path / "thin.eds"
    eds.write_text(re.sub(rf"(?m)^(\d+)=0x{missing}$", r"\1=0x1003", text), encoding="utf-8")
    bench = CanopenBench(eds)
    there = LIFE_TIME_OF_200_MS[missing == "100C"]
    bench.write(there)
    bench.send("000#01 05")
    assert bench.send(GUARD) == (["705#05"] if missing == "100D" else [])
    assert bench.after(5000) == []
