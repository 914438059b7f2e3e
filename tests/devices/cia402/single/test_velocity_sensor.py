"""6069h, the velocity of the encoder in increments per second of 6090h.

Source: CiA 402-2: velocity encoder resolution = encoder increments per second / motor revolutions per second.  Five
turns per second are 5 x 6090h:01 / 6090h:02, whatever units and polarity a user has.
"""

from pathlib import Path

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig_devices.cia402 import EDS

INCREMENTS_OF_608FH = 5_000_000


def turning_five_times_a_second(bench: SingleDriveBench, target: int = 5_000_000) -> SingleDriveBench:
    bench.put(0x6083, 500_000_000).enabled(3).put(0x60FF, target).after(1_000)
    assert abs(bench.read("speed")) == pytest.approx(300, rel=1e-3)
    return bench


@pytest.mark.parametrize(
    ("resolution", "velocity"),
    [
        ((1_000_000, 1), INCREMENTS_OF_608FH), ((4_096, 1), 20_480), ((2_147_483_648, 5_000), 2_147_484),
        ((10_000, 3), 16_667), ((4_000_000_000, 1), 2_147_483_647), ((1, 1), INCREMENTS_OF_608FH),
        ((0, 0), INCREMENTS_OF_608FH),
    ],
)  # fmt: skip
def test_it_counts_the_increments_of_6090h(resolution: tuple[int, int], velocity: int) -> None:
    bench = SingleDriveBench().put(0x6090, resolution[0], 1).put(0x6090, resolution[1], 2)
    assert turning_five_times_a_second(bench).get(0x6069) == pytest.approx(velocity, rel=1e-3)


def test_neither_units_nor_polarity_act_on_it() -> None:
    bench = SingleDriveBench().put(0x607E, 0xC0).put(0x60A9, 0x00B4_4700).put(0x6090, 4_096, 1)
    turning_five_times_a_second(bench, 300)
    assert bench.get(0x606C) == pytest.approx(300, abs=1)
    assert bench.get(0x6069) == pytest.approx(-20_480, rel=1e-3)


def test_it_is_0_at_standstill_and_turns_its_sign_with_the_motor() -> None:
    bench = SingleDriveBench().put(0x6090, 4_096, 1)
    assert bench.get(0x6069) == 0
    assert turning_five_times_a_second(bench, -5_000_000).get(0x6069) == pytest.approx(-20_480, rel=1e-3)


def test_it_is_sent_in_a_pdo() -> None:
    bench = SingleDriveBench().put(0x6090, 4_096, 1)
    bench.put(0x1803, 0x8000_0485, 1).put(0x1A03, 0, 0).put(0x1A03, 0x6069_0020, 1).put(0x1A03, 1, 0)
    bench.put(0x1803, 1, 2).put(0x1803, 0x485, 1)
    turning_five_times_a_second(bench)
    (frame,) = (frame for frame in bench.send("080#") if frame.startswith("485#"))
    assert int.from_bytes(bytes.fromhex(frame[4:]), "little", signed=True) == pytest.approx(20_480, rel=1e-3)


def test_without_6090h_an_increment_is_that_of_608fh(tmp_path: Path) -> None:
    lines = EDS.read_text(encoding="utf-8").splitlines()
    path = tmp_path / "their-drive.eds"
    blocks = "\n".join(line for line in lines if not line.endswith("=0x6090")).split("\n\n")
    path.write_text("\n\n".join(block for block in blocks if not block.startswith("[6090")), encoding="utf-8")
    bench = SingleDriveBench(eds=str(path))
    assert turning_five_times_a_second(bench).get(0x6069) == pytest.approx(INCREMENTS_OF_608FH, rel=1e-3)
