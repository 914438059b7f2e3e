"""Torques are per mille of 6076h, currents per mille of 6075h, and the motor gives its constant in N m for each ampere.

CiA 402-2, objects 6071h to 6078h.  The motor of the bench has 0.5 N m/A, 1.27 N m and 2.54 A.
"""

import math
import re
from pathlib import Path
from typing import Any

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402.single.own_objects import EDS

PT = 4


def bench_of(folder: Path, torque_mnm: int, current_ma: int, access: str = "ro", **keys: Any) -> SingleDriveBench:
    """Return a drive whose EDS says these rated values, blocked and at 50 % of the torque."""
    text = EDS.read_text()
    for index, value in (("6076", torque_mnm), ("6075", current_ma)):
        head, tail = text.split(f"[{index}]")
        tail = tail.replace("AccessType=ro\n", f"AccessType={access}\nDefaultValue={value}\n", 1)
        text = f"{head}[{index}]{tail}"
    file = folder / "drive.eds"
    file.write_text(text)
    bench = SingleDriveBench(eds=str(file), **keys)
    return bench.enabled(PT).wire("axis.blocked", True)


def push(bench: SingleDriveBench, torque: int = 500) -> float:
    """Set a target torque; return the torque of the motor in N m once it is there."""
    bench.put(0x6071, torque).after(2_000)
    return float(bench.read("torque"))


def test_the_motor_alone_says_what_its_values_are() -> None:
    bench = SingleDriveBench().enabled(PT).wire("axis.blocked", True)
    assert push(bench) == pytest.approx(0.635, abs=0.002)
    assert (bench.get(0x6077), bench.get(0x6078)) == (500, 500)


def test_the_values_of_a_file_are_the_base(tmp_path: Path) -> None:
    """50 % of 2 N m are 1 N m, which take 2 A: 40 % of 5 A."""
    bench = bench_of(tmp_path, 2_000, 5_000)
    assert (bench.get(0x6076), bench.get(0x6075)) == (2_000, 5_000)
    assert push(bench) == pytest.approx(1.0, abs=0.002)
    assert (bench.get(0x6077), bench.get(0x6078)) == (500, 400)


def test_the_limit_of_the_current_is_one_of_its_base(tmp_path: Path) -> None:
    """30 % of 5 A are 1.5 A, which give 0.75 N m: 37.5 % of 2 N m."""
    bench = bench_of(tmp_path, 2_000, 5_000)
    bench.put(0x6073, 300)
    assert push(bench) == pytest.approx(0.75, abs=0.002)
    assert (bench.get(0x6077), bench.get(0x6078)) == (375, 300)
    bench.put(0x6072, 200).after(500)
    assert bench.read("torque") == pytest.approx(0.4, abs=0.002)


def test_a_master_that_writes_the_rated_values_changes_the_base(tmp_path: Path) -> None:
    bench = bench_of(tmp_path, 2_000, 5_000, "rw")
    bench.put(0x6076, 1_000).put(0x6075, 2_000)
    assert push(bench) == pytest.approx(0.5, abs=0.002)
    assert (bench.get(0x6077), bench.get(0x6078)) == (500, 500)


def test_a_0_is_a_value_that_the_file_does_not_know(tmp_path: Path) -> None:
    assert push(bench_of(tmp_path, 0, 0)) == pytest.approx(0.635, abs=0.002)


def test_a_torque_base_by_current_does_not_look_at_the_rated_torque(tmp_path: Path) -> None:
    """50 % of 3 A are 1.5 A, which give 0.75 N m, whatever 6076h says."""
    bench = bench_of(tmp_path, 9_000, 3_000, behaviour={"torque_base": "current"})
    assert push(bench) == pytest.approx(0.75, abs=0.002)
    assert (bench.get(0x6077), bench.get(0x6078)) == (500, 500)


@pytest.mark.parametrize("feed", [("0", "0"), ("1", "0"), ("0", "1"), ("1", "1")])
def test_a_feed_constant_that_is_not_set_leaves_increments(tmp_path: Path, feed: tuple[str, str]) -> None:
    """6092h is not 0 by CiA 402-2; with one unit for a turn there would be no position within a turn."""
    text = EDS.read_text()
    for subindex, value in enumerate(feed, 1):
        head, tail = text.split(f"[6092sub{subindex}]")
        text = f"{head}[6092sub{subindex}]" + re.sub("DefaultValue=.*", f"DefaultValue={value}", tail, count=1)
    file = tmp_path / "drive.eds"
    file.write_text(text)
    bench = SingleDriveBench(eds=str(file)).enabled(1)
    bench.put(0x607A, bench.get(0x608F, 1)).control(0x1F)
    bench.until(lambda: bench.status(0x0400) != 0, 20_000)
    assert bench.read("position") == pytest.approx(math.tau, rel=1e-3)
