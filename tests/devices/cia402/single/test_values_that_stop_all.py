"""Values in a file with which a mode could never work, as they are in public files, do not stop the drive.

Each test has our own EDS with one oddity: a buffer of set-points of size 0 (60C4h sub-index 2), and a file that
gives no 6502h and whose 6060h accepts fewer modes than it has targets for.
"""

from pathlib import Path

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402.single.foreign import declared
from fieldrig_devices.cia402.single.own_objects import EDS

IP = 7


def written(folder: Path, section: str, was: str, becomes: str) -> Path:
    """Return our EDS with one line of a section replaced."""
    head, tail = EDS.read_text("utf-8").split(f"[{section}]\n", 1)
    assert was in tail.split("\n[", 1)[0]
    file = folder / "drive.eds"
    file.write_text(f"{head}[{section}]\n{tail.replace(was, becomes, 1)}", "utf-8")
    return file


def test_a_buffer_of_no_set_points_counts_as_not_set(tmp_path: Path) -> None:
    bench = SingleDriveBench(
        eds=str(written(tmp_path, "60C4sub2", "LowLimit=1\nHighLimit=64\nDefaultValue=64", "DefaultValue=0"))
    )
    assert bench.get(0x60C4, 2) == 0  # a master reads what the file says
    bench.enabled(IP).put(0x60C2, 10, 1).control(0x1F)
    begin = bench.get(0x6064)
    for step in range(1, 11):
        bench.put(0x60C1, begin + step * 1_000, 1).after(10)
    bench.after(500)
    assert bench.get(0x6064) == pytest.approx(begin + 10_000, abs=5)


def test_without_a_value_of_6502h_the_limits_of_6060h_say_which_modes_there_are(tmp_path: Path) -> None:
    file = written(tmp_path, "6060", "DefaultValue=0\n", "DefaultValue=0\nLowLimit=-1\nHighLimit=0x6\n")
    assert declared(file).behaviour.modes == frozenset({-1, 1, 2, 3, 4, 6})
