"""Storing, restoring and verifying parameters, CiA 301 7.5.2.10, 7.5.2.11 and 7.5.2.24."""

import json
import logging
import os
import signal
import subprocess
import sys
from pathlib import Path

import canopen_bench
import pytest
from canopen_bench import LEVEL_SENSOR, CanopenBench
from full_store import FullStore

from fieldrig.storage.store import FileStore, MemoryStore

RESET_NODE, RESET_COMMUNICATION = "000#81 05", "000#82 05"
HEARTBEAT_100_MS, READ_HEARTBEAT = "2b 17 10 00 64 00 00 00", "40 17 10 00 00 00 00 00"
DELTA_7, READ_DELTA = "23 26 64 01 07 00 00 00", "40 26 64 01 00 00 00 00"
OFFSET_9, READ_OFFSET = "2b 02 20 00 09 00 00 00", "40 02 20 00 00 00 00 00"


def save(sub: int) -> str:
    return f"23 10 10 {sub:02x} 73 61 76 65"


def load(sub: int) -> str:
    return f"23 11 10 {sub:02x} 6c 6f 61 64"


def changed(bench: CanopenBench) -> tuple[bool, bool, bool]:
    """True for each parameter of communication, application and manufacturer that differs from its default."""
    return (
        bench.sdo(READ_HEARTBEAT) == "4b 17 10 00 64 00 00 00",
        bench.sdo(READ_DELTA) == "43 26 64 01 07 00 00 00",
        bench.sdo(READ_OFFSET) == "4b 02 20 00 09 00 00 00",
    )


@pytest.fixture
def set_up(bench: CanopenBench) -> CanopenBench:
    bench.write(HEARTBEAT_100_MS, DELTA_7, OFFSET_9)
    return bench


def test_what_can_be_stored_and_restored_is_told(bench: CanopenBench) -> None:
    for index in ("10", "11"):
        for sub in ("01", "02", "03", "04"):
            assert bench.sdo(f"40 {index} 10 {sub} 00 00 00 00") == f"43 {index} 10 {sub} 01 00 00 00"


@pytest.mark.parametrize(
    ("sub", "kept"),
    [(1, (True, True, True)), (2, (True, False, False)), (3, (False, True, False)), (4, (False, False, True))],
)
def test_stored_parameters_outlast_reset_and_power_off(
    set_up: CanopenBench, sub: int, kept: tuple[bool, bool, bool]
) -> None:
    set_up.write(save(sub))
    assert changed(set_up) == (True, True, True)
    set_up.send(RESET_NODE)
    assert changed(set_up) == kept
    assert changed(CanopenBench(store=set_up.store)) == kept


def test_without_storing_all_is_as_the_factory_has_it(set_up: CanopenBench) -> None:
    set_up.send(RESET_NODE)
    assert changed(set_up) == (False, False, False)
    assert set_up.store.load() is None


@pytest.mark.parametrize(
    ("sub", "kept"),
    [(1, (False, False, False)), (2, (False, True, True)), (3, (True, False, True)), (4, (True, True, False))],
)
def test_restored_parameters_take_effect_after_the_reset(
    set_up: CanopenBench, sub: int, kept: tuple[bool, bool, bool]
) -> None:
    set_up.write(save(1), load(sub))
    assert changed(set_up) == (True, True, True)
    assert changed(CanopenBench(store=set_up.store)) == kept
    set_up.send(RESET_NODE)
    assert changed(set_up) == kept


def test_reset_of_communication_brings_back_what_was_stored_of_it(set_up: CanopenBench) -> None:
    set_up.write(save(2), "2b 17 10 00 00 00 00 00")
    set_up.send(RESET_COMMUNICATION)
    assert changed(set_up) == (True, True, True)


@pytest.mark.parametrize(
    ("request_", "answer"),
    [
        ("23 10 10 01 65 76 61 73", "80 10 10 01 20 00 00 08"),  # evas
        ("23 10 10 01 6c 6f 61 64", "80 10 10 01 20 00 00 08"),  # load
        ("23 11 10 01 73 61 76 65", "80 11 10 01 20 00 00 08"),  # save
        ("23 11 10 01 6e 6f 72 77", "80 11 10 01 20 00 00 08"),
        ("23 10 10 00 73 61 76 65", "80 10 10 00 02 00 01 06"),
        ("23 10 10 05 73 61 76 65", "80 10 10 05 11 00 09 06"),
        ("2b 10 10 01 73 61 00 00", "80 10 10 01 13 00 07 06"),
    ],
)
def test_wrong_signature_stores_nothing(set_up: CanopenBench, request_: str, answer: str) -> None:
    assert set_up.sdo(request_) == answer
    assert set_up.store.load() is None


def test_outputs_are_no_parameters(bench: CanopenBench) -> None:
    bench.write("2f 00 62 01 ff 00 00 00", save(1))
    bench.send(RESET_NODE)
    assert bench.point("6200:01") == 0


def test_pdos_run_as_stored(bench: CanopenBench) -> None:
    bench.write("23 00 18 01 85 01 00 c0", "2f 00 18 02 01 00 00 00", "23 00 18 01 90 01 00 40", save(2))
    bench.send(RESET_NODE, "000#01 05")
    assert bench.send("080#") == ["190#00 00 00 00"]


def test_default_cob_ids_follow_another_node_id(bench: CanopenBench) -> None:
    bench.write(HEARTBEAT_100_MS, save(1))
    other = CanopenBench(node_id=6, store=bench.store)
    assert other.point("1800:01") == 0x4000_0186
    assert other.point("1017:00") == 100


def test_stored_values_are_written_before_the_answer_and_kept_over_a_kill(tmp_path: Path) -> None:
    store = FileStore(tmp_path / "io.store")
    bench = CanopenBench(store=store)
    bench.write(HEARTBEAT_100_MS, save(1))
    assert CanopenBench(store=FileStore(tmp_path / "io.store")).point("1017:00") == 100


def test_store_that_fails_is_a_hardware_error_and_changes_nothing() -> None:
    store = FullStore()
    bench = CanopenBench(store=store)
    bench.write(HEARTBEAT_100_MS)
    assert bench.sdo(save(1)) == "80 10 10 01 00 00 06 06"
    bench.send(RESET_NODE)
    assert bench.point("1017:00") == 0
    store.is_full = False
    bench.write(HEARTBEAT_100_MS, save(1))
    assert CanopenBench(store=store).point("1017:00") == 100


# Content of another program, or of another EDS, in the store.


def stored(objects: dict[str, str], version: int = 1) -> MemoryStore:
    lss = {"node_id": None, "in_place_of": 5, "bit_timing": None}
    return MemoryStore(json.dumps({"version": version, "lss": lss, "objects": objects}).encode())


def test_stored_values_that_no_longer_fit_are_ignored(caplog: pytest.LogCaptureFixture) -> None:
    objects = {"1017:00": "6400", "1018:04": "01000000", "2002:00": "ff7f", "6426:01": "07", "5555:00": "01"}
    bench = CanopenBench(store=stored(objects))
    assert [bench.point(key) for key in ("1017:00", "1018:04", "2002:00", "6426:01")] == [100, 1, 0, 0]
    assert caplog.text.count("is ignored") == 3


def test_store_of_another_device_does_no_harm() -> None:
    bench = CanopenBench(LEVEL_SENSOR, store=stored({"1017:00": "6400", "6426:01": "07000000"}))
    assert bench.point("1017:00") == 100


@pytest.mark.parametrize(
    "data",
    [
        b"",
        b"\x00\xff",
        b"[]",
        b"{}",
        b"null",
        b'{"version": 2}',
        b'{"version": 1, "objects": [], "lss": {}}',
        b'{"version": 1, "objects": {"1017:00": 5}, "lss": {}}',
        b'{"version": 1, "objects": {}, "lss": {"node_id": "x", "in_place_of": 5, "bit_timing": null}}',
    ],
)
def test_broken_store_is_as_none(data: bytes, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        bench = CanopenBench(store=MemoryStore(data))
    assert bench.take() == ["705#00"]
    assert "cannot be used" in caplog.text


# 1020h: date and time of the configuration

DATED = ("23 20 10 01 2f 3d 00 00", "23 20 10 02 00 51 25 02")


def date(bench: CanopenBench) -> list[object]:
    return [bench.point("1020:01"), bench.point("1020:02")]


def test_date_of_the_configuration_is_stored_with_it(bench: CanopenBench) -> None:
    bench.write(*DATED, save(1))
    bench.send(RESET_NODE)
    assert date(bench) == [0x3D2F, 0x0225_5100]


@pytest.mark.parametrize("change", [HEARTBEAT_100_MS, DELTA_7, OFFSET_9])
def test_any_change_of_the_configuration_clears_its_date(bench: CanopenBench, change: str) -> None:
    bench.write(*DATED, change)
    assert date(bench) == [0, 0]


@pytest.mark.parametrize("request_", ["2f 00 62 01 ff 00 00 00", "2b 17 10 00 00 00 00 00", save(1)])
def test_outputs_and_what_changes_nothing_leave_the_date(bench: CanopenBench, request_: str) -> None:
    bench.write(*DATED, request_)
    assert date(bench) == [0x3D2F, 0x0225_5100]


# A kill

SAVE_AND_WAIT = """
import sys, time
from pathlib import Path
from canopen_bench import CanopenBench
from fieldrig.storage.store import FileStore

bench = CanopenBench(store=FileStore(Path(sys.argv[1])))
bench.write("2b 17 10 00 64 00 00 00", "23 10 10 01 73 61 76 65")
print("stored", flush=True)
time.sleep(60)
"""


@pytest.mark.system
def test_what_was_confirmed_outlasts_a_killed_process(tmp_path: Path) -> None:
    path = tmp_path / "io.store"
    with subprocess.Popen(
        [sys.executable, "-c", SAVE_AND_WAIT, str(path)],
        stdout=subprocess.PIPE,
        env=os.environ | {"PYTHONPATH": str(Path(canopen_bench.__file__).parent)},
    ) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == b"stored\n"
        process.kill()
    assert process.returncode == -signal.SIGKILL
    assert CanopenBench(store=FileStore(path)).point("1017:00") == 100
