"""Units of velocities and accelerations by 60A8h to 60AAh, by 608Bh and 608Ch of the older edition, and by factors.

Source: CiA 303-2 for the codes, CiA 402-2 for the objects.  The shaft turns once for three turns of the motor.
"""

from configparser import ConfigParser
from math import tau
from pathlib import Path

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402 import EDS

POSITION, VELOCITY, ACCELERATION = 0x60A8, 0x60A9, 0x60AA
INCREMENTS, DEGREE, MILLIMETRE, REVOLUTION = 0x00B5_0000, 0x0041_0000, 0xFD01_0000, 0x00B4_0000
RPM, MILLI_RPM, RPM_PER_S = 0x00B4_4700, 0xFDB4_4700, 0x00C0_0300
NO_WINDOW, MOST = 0xFFFF_FFFF, 0x7FFF_FFFF


def geared() -> SingleDriveBench:
    return SingleDriveBench().put(0x6065, NO_WINDOW).put(0x607F, MOST).put(0x6091, 3, 1)


def turning(bench: SingleDriveBench, velocity: int) -> float:
    """The speed of the motor in min-1 for a target velocity."""
    bench.put(ACCELERATION, RPM_PER_S).put(0x6083, 10_000).enabled(3).put(0x60FF, velocity).after(1_000)
    assert bench.get(0x606C) == pytest.approx(velocity, abs=1, rel=1e-4)
    return float(bench.read("speed"))


@pytest.mark.parametrize(
    ("position", "feed", "velocity", "value", "rpm"),
    [
        (INCREMENTS, 1_000_000, RPM, 300, 300),
        (INCREMENTS, 1_000_000, MILLI_RPM, 300_000, 300),
        (INCREMENTS, 1_000_000, 0x00B5_0300, 5_000_000, 900),
        (INCREMENTS, 1_000_000, 0x00B4_0300, 5, 300),
        (DEGREE, 360, RPM, 300, 900),
        (DEGREE, 360, 0x0041_0300, 1_800, 900),
        (DEGREE, 360, 0x0010_0300, 31, 31 / tau * 180),
        (DEGREE, 360, 0x00B5_0300, 5_000_000, 300),
        (MILLIMETRE, 10, 0xFD01_0300, 50, 900),
        (MILLIMETRE, 10, 0x0001_4700, 3, 900),
        (REVOLUTION, 1, 0xFEB4_0300, 500, 900),
        (MILLIMETRE, 10, 0, 50, 900),
    ],
)
def test_velocities_are_in_the_unit_of_60a9h(position: int, feed: int, velocity: int, value: int, rpm: float) -> None:
    bench = geared().put(POSITION, position).put(0x6092, feed, 1).put(VELOCITY, velocity)
    assert turning(bench, value) == pytest.approx(rpm, rel=1e-3)


@pytest.mark.parametrize(
    ("unit", "value"),
    [
        (RPM_PER_S, 600), (0xFDC0_0300, 600_000), (0x00C0_4700, 36_000), (0x00B4_5700, 10), (0x0041_5700, 3_600),
        (0x00B5_5700, 10_000_000), (0, 10_000_000),
    ],
)  # fmt: skip
def test_accelerations_are_in_the_unit_of_60aah(unit: int, value: int) -> None:
    bench = SingleDriveBench().put(VELOCITY, RPM).put(ACCELERATION, unit).put(0x6083, value)
    bench.enabled(3).put(0x60FF, 300).after(250)
    assert bench.get(0x606B) == pytest.approx(150, abs=1)


@pytest.mark.parametrize(
    ("index", "unit"),
    [
        (POSITION, 0x0003_0000), (POSITION, RPM), (VELOCITY, 0x0002_0300), (VELOCITY, REVOLUTION), (VELOCITY, RPM + 1),
        (VELOCITY, 0x40B4_4700), (ACCELERATION, RPM), (ACCELERATION, 0x00C0_5700),
    ],
)  # fmt: skip
def test_a_unit_that_is_none_is_refused(index: int, unit: int) -> None:
    bench = SingleDriveBench()
    before = bench.get(index)
    assert bench.try_put(index, unit) == "06090030"
    assert bench.get(index) == before


def test_a_reset_brings_the_unit_back() -> None:
    bench = SingleDriveBench().put(VELOCITY, RPM)
    bench.send("000#81 05")
    bench.send("000#01 05")
    bench.after(5)
    bench.enabled(3).put(0x60FF, 1_000_000).after(2_000)
    assert bench.read("speed") == pytest.approx(60, rel=1e-3)


def without(tmp_path: Path, *keys: str, **values: str) -> str:
    """Our EDS without some objects, and with other values of others."""
    blocks = EDS.read_text(encoding="utf-8").split("\n\n")
    blocks = [block for block in blocks if not block.startswith(tuple(f"[{key}" for key in keys))]
    for key, value in values.items():
        place = next(place for place, block in enumerate(blocks) if block.startswith(f"[{key.removeprefix('x')}]"))
        lines = [line for line in blocks[place].splitlines() if not line.startswith("DefaultValue")]
        blocks[place] = "\n".join([*lines, f"DefaultValue={value}"])
    path = tmp_path / "their-drive.eds"
    text = "\n\n".join(blocks)
    for key in keys:
        text = "\n".join(line for line in text.splitlines() if not line.endswith(f"=0x{key}"))
    path.write_text(text, encoding="utf-8")
    return str(path)


def test_limits_that_a_file_lacks_follow_the_unit(tmp_path: Path) -> None:
    bench = SingleDriveBench(eds=without(tmp_path, "607F", "60C5", "60C6", x60A9=hex(RPM)))
    bench.put(VELOCITY, MILLI_RPM)
    assert turning(bench, 300_000) == pytest.approx(300, rel=1e-3)


@pytest.mark.parametrize("unit", [0x0041_0000, 0xFF41_0000, 0xFDB4_0000])
def test_without_a_feed_constant_the_user_unit_is_the_angle_of_60a8h(tmp_path: Path, unit: int) -> None:
    bench = SingleDriveBench(eds=without(tmp_path, "6092", "60A9", "60AA", x60A8=hex(unit)))
    turn = {0x0041_0000: 360, 0xFF41_0000: 3_600, 0xFDB4_0000: 1_000}[unit]
    bench.put(0x6065, NO_WINDOW).put(0x6081, turn * 5).put(0x6083, turn * 50).put(0x6084, turn * 50)
    bench.enabled(1).put(0x607A, turn).control(0x1F).after(2_000)
    assert bench.get(0x6064) == turn
    assert bench.read("position") == pytest.approx(tau, rel=1e-3)


@pytest.mark.parametrize("start", ["", "0"])
def test_a_profile_velocity_that_a_file_does_not_know_is_that_of_our_own_drive(tmp_path: Path, start: str) -> None:
    """6081h is 0 for the master until it writes it; makers keep the value in the memory of their drives."""
    bench = SingleDriveBench(eds=without(tmp_path, "0000", x6081=start))
    assert bench.get(0x6081) == 0
    bench.enabled(1).put(0x607A, 2_000_000).control(0x1F).after(1_000)
    assert bench.get(0x606C) == 1_000_000
    bench.control(0x0F).put(0x6081, 500_000).control(0x3F).after(1_000)
    assert bench.get(0x606C) == 500_000


def with_factors(tmp_path: Path, **starts: int) -> str:
    """Our EDS with 6096h and 6097h instead of the units 60A9h and 60AAh; `starts` are numerators, such as `x6096`."""
    path = Path(without(tmp_path, "60A9", "60AA"))
    file = ConfigParser(interpolation=None)
    file.optionxform = str  # type: ignore[assignment,method-assign]
    file.read(path, encoding="utf-8")
    listed = file["OptionalObjects"]
    for index in ("6096", "6097"):
        count = int(listed["SupportedObjects"]) + 1
        listed["SupportedObjects"], listed[str(count)] = str(count), f"0x{index}"
        file[index] = {"ParameterName": "Factor", "ObjectType": "0x9", "SubNumber": "3"}
        for subindex, number in enumerate((2, starts.get(f"x{index}", 1), 1)):
            access, kind = ("rw", "0x7") if subindex else ("const", "0x5")
            entry = {"ParameterName": f"Number {subindex}", "DataType": kind, "AccessType": access}
            file[f"{index}sub{subindex}"] = entry | {"DefaultValue": str(number)}
    with path.open("w", encoding="utf-8") as text:
        file.write(text, space_around_delimiters=False)
    return str(path)


@pytest.mark.parametrize(
    ("factor", "velocity", "rpm"),
    [((1, 1), 5_000_000, 300), ((60, 1_000_000), 300, 300), ((2, 1), 10_000_000, 300), ((1, 2), 2_500_000, 300)],
)
def test_a_velocity_is_the_positions_per_second_times_6096h(
    tmp_path: Path, factor: tuple[int, int], velocity: int, rpm: int
) -> None:
    """A turn has a million increments, so 60 by a million makes min-1 of them."""
    bench = SingleDriveBench(eds=with_factors(tmp_path)).put(0x6065, NO_WINDOW).put(0x607F, MOST)
    bench.put(0x6096, factor[0], 1).put(0x6096, factor[1], 2)
    bench.put(0x6083, 500_000_000).enabled(3).put(0x60FF, velocity).after(1_000)
    assert bench.get(0x606C) == pytest.approx(velocity, abs=1, rel=1e-4)
    assert bench.read("speed") == pytest.approx(rpm, rel=1e-3)


@pytest.mark.parametrize(
    ("factor", "acceleration"), [((1, 1), 10_000_000), ((60, 1_000_000), 600), ((3, 1), 30_000_000)]
)
def test_an_acceleration_is_the_positions_per_second_squared_times_6097h(
    tmp_path: Path, factor: tuple[int, int], acceleration: int
) -> None:
    """It does not follow 6096h."""
    bench = SingleDriveBench(eds=with_factors(tmp_path)).put(0x6096, 60, 1).put(0x6096, 1_000_000, 2)
    bench.put(0x6097, factor[0], 1).put(0x6097, factor[1], 2).put(0x6083, acceleration)
    bench.enabled(3).put(0x60FF, 300).after(250)
    assert bench.get(0x606B) == pytest.approx(150, abs=1)


def test_a_factor_of_the_file_counts_from_the_start(tmp_path: Path) -> None:
    bench = SingleDriveBench(eds=with_factors(tmp_path, x6096=1_000)).put(0x607F, MOST)
    bench.put(0x6083, 500_000_000).enabled(3).put(0x60FF, 500_000_000).after(1_000)
    assert bench.read("speed") == pytest.approx(30, rel=1e-3)


def test_a_factor_of_0_is_taken_as_1(tmp_path: Path) -> None:
    bench = SingleDriveBench(eds=with_factors(tmp_path)).put(0x6096, 0, 1).put(0x6096, 0, 2)
    bench.put(0x6083, 500_000_000).enabled(3).put(0x60FF, 5_000_000).after(1_000)
    assert bench.read("speed") == pytest.approx(300, rel=1e-3)
