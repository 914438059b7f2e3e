"""Slave cams, MultiCam3, torque cams, positioning functions, splines, and a whole controller."""

from math import pi, sin
from pathlib import Path
from typing import Any

import pytest
from cam_bench import CYCLE_NS, CamBench
from hypothesis import given
from hypothesis import strategies as st
from max4_bench import Bench

from fieldrig.clock import S
from fieldrig.errors import ConfigError
from fieldrig_devices.iec.parser import parse
from fieldrig_devices.iec.tree import Pou
from fieldrig_devices.max4.axes.axis import Mode
from fieldrig_devices.max4.libraries.collection import motion_libraries
from fieldrig_devices.max4.libraries.controller import SystemMotion
from fieldrig_devices.motion.curves.spline import profile_of_file, spline


@pytest.fixture
def bench() -> CamBench:
    return CamBench()


# ---- slave cams


@pytest.mark.manual("PD-186")
def test_a_slave_cam_needs_an_active_master_cam(bench: CamBench) -> None:
    straight, bump = bench.call("ProfilLoad", "straight"), bench.call("ProfilLoad", "simpsin")
    assert bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=200)[0] == -7
    bench.part(straight, 1000.0, 1000.0)
    assert bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=200) == (0, True, False)
    bench.master.position = 1001.0
    bench.run(1)  # the master cam is over
    assert bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=300)[0] == -7


@pytest.mark.manual("PD-186")
def test_a_slave_cam_adds_its_way_to_that_of_the_master_cam(bench: CamBench) -> None:
    straight, bump = bench.call("ProfilLoad", "straight"), bench.call("ProfilLoad", "quadpara")
    bench.part(straight, 1000.0, 1000.0)
    begin, bench.master.position = bench.place(), 100.0
    bench.run(1)
    bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=200)
    for x, added in ((100.0, 0.0), (125.0, 2.5), (150.0, 5.0), (300.0, 5.0)):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(x + added, abs=1e-3)
    assert bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=200, bReset=False) == (0, False, True)
    bench.part(bump, 50.0, 5.0, kind="SLAVECAM", instance=300)  # another one, which adds to the first
    bench.master.position = 350.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(360.0, abs=1e-3)


# ---- MultiCam3


@pytest.mark.manual("PD-080")
def test_three_axes_follow_one_master(bench: CamBench) -> None:
    bench = CamBench("one", "two", "three")
    profiles = [bench.call("ProfilLoad", name) for name in ("straight", "simpsin", "quadpara")]
    pins = [
        value for number, axis in enumerate(bench.axes.values()) for value in (axis.log_adr, profiles[number], 10.0)
    ]
    begins = [bench.place(name) for name in bench.axes]
    bench.master.position = 77.0
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, True) == (0, True, False)
    bench.master.position = 77.0 + 25.0
    bench.run(1)
    ways = [bench.place(name) - begin for name, begin in zip(bench.axes, begins, strict=True)]
    assert ways == pytest.approx([2.5, 5 * (1 - 2**-0.5), 1.25], abs=2e-3)
    bench.master.position = 200.0
    bench.run(1)
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, False) == (0, False, True)


@pytest.mark.manual("PD-080")
def test_multicam_begins_on_all_axes_or_on_none(bench: CamBench) -> None:
    bench = CamBench("one", "two")
    straight = bench.call("ProfilLoad", "straight")
    bench.part(straight, 100.0, 100.0, axis="two")
    bench.part(straight, 100.0, 100.0, axis="two", instance=200)
    one, two = (axis.log_adr for axis in bench.axes.values())
    pins = (one, straight, 10.0, two, straight, 10.0, 0, 0, 0.0)
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, True) == (1, False, False)
    assert bench.part(straight, 100.0, 100.0, axis="one", instance=300) == (0, True, False)
    nobody = (0, 0, 0.0) * 3
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *nobody, True)[0] == -1
    twice = (one, straight, 10.0, one, straight, 10.0, 0, 0, 0.0)
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *twice, True)[0] == -1
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, True)[0] == 1
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, False)[0] == 1
    bench.master.position = 120.0  # the first cam of `two` is over, so it has room
    bench.run(1)
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, False)[0] == 0


@pytest.mark.manual("PD-080")
@pytest.mark.parametrize("place", [0, 1, 2])
def test_multicam_with_one_axis_only(place: int) -> None:
    bench = CamBench("one")
    straight = bench.call("ProfilLoad", "straight")
    pins: list[Any] = [0, 0, 1.0] * 3
    pins[3 * place : 3 * place + 3] = bench.axes["one"].log_adr, straight, 30.0
    begin = bench.place("one")
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 100.0, *pins, True) == (0, True, False)
    bench.master.position = 50.0
    bench.run(1)
    assert bench.place("one") - begin == pytest.approx(15.0, abs=1e-3)


@pytest.mark.manual("PD-196")
def test_axes_stop_together_in_proportion() -> None:
    bench = CamBench("one", "two", "three")
    stop = bench.call("ProfilLoad", "modisin")
    bench.call("ProfilSetLambda", stop, 0.0)
    heights = (100.0, 50.0, -25.0)
    pins = [value for axis, y in zip(bench.axes.values(), heights, strict=True) for value in (axis.log_adr, stop, y)]
    begins = [bench.place(name) for name in bench.axes]
    assert bench.block("MultiCam3", 1, bench.master.object.log_adr, 200.0, *pins, True)[0] == 0
    bench.master.velocity = 500.0
    bench.run(150)
    for places in bench.places:
        shares = [(place - begin) / y for place, begin, y in zip(places, begins, heights, strict=True)]
        assert shares == pytest.approx([shares[0]] * 3, abs=1e-4)
    ends = [next(n for n, v in enumerate(bench.speeds(axis)) if n > 5 and v == 0.0) for axis in range(3)]
    assert max(ends) - min(ends) <= 8  # one increment of the slowest axis takes longer near its rest


@pytest.mark.manual("PD-205", "PD-203")
def test_the_libraries_have_the_names_of_the_manual(bench: CamBench) -> None:
    assert [library.name for library in bench.libraries] == [
        "Basic.lib",
        "VarioCam.lib",
        "CSpline.lib",
        "TorqueCam.lib",
    ]
    for library in bench.libraries:
        unit, mistakes = parse(library.text, library.name)
        assert mistakes == []
        natives = {pou.name.casefold() for pou in unit.declarations if isinstance(pou, Pou)}
        assert natives == {*library.functions, *library.blocks}


# ---- torque cams


@pytest.mark.manual("PD-195")
def test_the_torque_follows_the_master(bench: CamBench) -> None:
    profile = bench.call("ProfilLoad", "simpsin")
    assert bench.part(profile, 100.0, 80.0, kind="TORQUECAM") == (0, True, False)
    axis = bench.axes["belt"]
    for x, percent in ((0.0, 0.0), (25.0, 40 * (1 - 2**-0.5)), (50.0, 40.0), (100.0, 80.0), (300.0, 80.0)):
        bench.master.position = x
        bench.run(1)
        assert axis.mode.name == "TORQUE"
        assert axis.set_value == pytest.approx(percent * 10, abs=0.5)
    assert bench.part(profile, 100.0, 80.0, kind="TORQUECAM", bReset=False) == (0, False, True)
    straight = bench.call("ProfilLoad", "straight")
    assert bench.part(straight, 100.0, 100.0, instance=200)[0] == 0  # back to positions, from where the axis is
    bench.run(1)
    assert bench.axes["belt"].mode is Mode.POSITION


# ---- positioning


@pytest.mark.manual("PD-203")
def test_an_axis_moves_to_a_position_and_by_a_distance(bench: CamBench) -> None:
    address = bench.axes["belt"].log_adr
    assert bench.call("PosAbsolute", address, 50.0, 100.0, 1000.0, 1000.0) == 0
    bench.run(50)
    assert not bench.call("PosDone", address)
    bench.run(150)
    assert (bench.place(), bench.call("PosDone", address)) == (50.0, True)
    assert max(bench.speeds()) == pytest.approx(100.0, abs=0.3)
    assert bench.call("PosRelative", address, -20.0, 100.0, 1000.0, 1000.0) == 0
    bench.run(200)
    assert bench.place() == 30.0


@pytest.mark.manual("PD-203")
def test_an_axis_runs_at_a_speed_until_it_is_stopped(bench: CamBench) -> None:
    address = bench.axes["belt"].log_adr
    assert bench.call("PosVelocity", address, -50.0, 500.0, 500.0) == 0
    bench.run(100)
    assert bench.speeds()[-1] == pytest.approx(-50.0, abs=0.3)
    assert bench.call("PosStop", address, 500.0) == 0
    bench.run(100)
    assert bench.speeds()[-1] == 0.0


def test_positioning_refuses_what_no_axis_can_do(bench: CamBench) -> None:
    address = bench.axes["belt"].log_adr
    assert bench.call("PosAbsolute", 1, 50.0, 100.0, 1000.0, 1000.0) == -1
    assert bench.call("PosAbsolute", address, float("nan"), 100.0, 1000.0, 1000.0) == -4
    assert bench.call("PosAbsolute", address, 50.0, 0.0, 1000.0, 1000.0) == -4
    assert bench.call("PosStop", address, -5.0) == -4
    assert not bench.call("PosDone", 1)


# ---- own profiles

FILE = b"""# a lift with a rest
slopes 0 0
0    0
90 ; 10.0   # quarter turn
180\t12.5
360  0
"""


@pytest.mark.manual("PD-185")
def test_a_profile_of_a_file_passes_its_support_points() -> None:
    bench = CamBench(files={"\\LIFT.CAM": FILE})
    profile = bench.call("ProfilLoad", "lift")
    assert profile == 1
    bench.cam(profile, lrXFactor=360.0)
    begin = bench.place()
    for x, y in ((0.0, 0.0), (90.0, 10.0), (180.0, 12.5), (360.0, 0.0)):
        bench.master.position = x
        bench.run(1)
        assert bench.place() - begin == pytest.approx(y, abs=1e-3)


@pytest.mark.manual("PD-185")
def test_support_points_become_a_profile_online(bench: CamBench) -> None:
    points = bench.call("CSplineBegin")
    for x, y in ((0.0, 0.0), (1.0, 3.0), (2.0, 0.0)):
        assert bench.call("CSplinePoint", points, x, y)
    assert not bench.call("CSplinePoint", 99, 0.0, 0.0)
    profile = bench.call("CSplineProfil", points)
    bench.cam(profile, lrXFactor=2.0)
    begin, bench.master.position = bench.place(), 1.0
    bench.run(1)
    assert bench.place() - begin == pytest.approx(3.0, abs=1e-3)
    assert bench.call("CSplineProfil", bench.call("CSplineBegin")) == 0


@pytest.mark.manual("PD-185")
@given(st.lists(st.tuples(st.floats(0.01, 10), st.floats(-100, 100)), min_size=1, max_size=12))
def test_a_spline_is_smooth_and_passes_its_points(steps: list[tuple[float, float]]) -> None:
    points, x = [(0.0, 0.0)], 0.0
    for width, y in steps:
        x += width
        points.append((x, y))
    profile = spline(points)
    for place, y in points:
        assert profile.at(place / x) == pytest.approx(y, abs=1e-6)
    bends = [0.0]
    for left, right in zip(profile.pieces[1:-1], profile.pieces[2:-1], strict=False):
        assert left.at(left.length) == pytest.approx(right.at(0.0), abs=1e-6)
        scale = max(1.0, abs(right.slope(0.0)))
        assert left.slope(left.length) == pytest.approx(right.slope(0.0), abs=1e-6 * scale)
        bend = 2 * left.powers[2] + 6 * left.powers[3] * left.length
        assert bend == pytest.approx(2 * right.powers[2], abs=1e-6 * max(1.0, abs(bend)))
        bends.append(bend)
    assert profile.pieces[1].powers[2] == 0.0  # natural


def test_a_clamped_spline_of_a_cubic_is_the_cubic() -> None:
    profile = spline([(x, x**3) for x in (0.0, 0.3, 0.5, 1.0)], (0.0, 3.0))
    for step in range(11):
        assert profile.at(step / 10) == pytest.approx((step / 10) ** 3)


def test_a_spline_of_a_sine_is_close_to_the_sine() -> None:
    profile = spline([(x / 40, sin(pi * x / 40)) for x in range(41)])
    assert max(abs(profile.at(z / 1000) - sin(pi * z / 1000)) for z in range(1001)) < 1e-6


@pytest.mark.parametrize(
    ("data", "wrong"),
    [
        (b"", "2 to 4096 support points, got 0"),
        (b"0 0\n1 x", "line 2: expected two numbers, got '1 x'"),
        (b"0 0 0\n", "line 1: expected two numbers"),
        (b"0 0\n2 1\n1 5", "expected rising x values, got 1 behind 2"),
        (b"0 0\n0 1", "expected rising x values"),
        (b"0 0\n1 nan", "finite"),
        (b"slopes 1\n0 0\n1 1", "line 1: expected two numbers"),
    ],
)
def test_a_wrong_file_is_refused_with_its_line(data: bytes, wrong: str) -> None:
    with pytest.raises(ValueError, match=wrong.replace("(", r"\(")):
        profile_of_file(data)


@given(st.binary(max_size=200) | st.text("0123456789.-+e ;\n#slopesnaif", max_size=200).map(str.encode))
def test_no_file_does_more_than_be_refused(data: bytes) -> None:
    try:
        profile = profile_of_file(data)
    except ValueError:
        return
    assert profile.starts[-1] == 1.0


@pytest.mark.manual("PD-185")
def test_a_wrong_file_has_no_number() -> None:
    bench = CamBench(files={"\\BAD.CAM": b"0 0\n"})
    assert bench.call("ProfilLoad", "\\bad.cam") == 0


# ---- on the controller


@pytest.mark.manual("PD-185")
def test_files_of_the_rig_file_are_on_the_flash_disk(tmp_path: Path) -> None:
    (tmp_path / "lift.cam").write_bytes(FILE)
    settings: dict[str, Any] = {"simulated": ("Belt",), "files": [str(tmp_path / "lift.cam")]}
    bench = Bench(**settings)
    assert bench.max4.firmware.disk.read("\\LIFT.CAM") == FILE
    (tmp_path / "lift.cam").write_bytes(b"0 0\n1 1\n")
    assert Bench(store=bench.store, **settings).max4.firmware.disk.read("\\LIFT.CAM") == b"0 0\n1 1\n"
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "LIFT.CAM").write_bytes(FILE)
    with pytest.raises(ConfigError, match=r"\\LIFT.CAM is used twice"):
        Bench(simulated=("Belt",), files=[str(tmp_path / name) for name in ("lift.cam", "other/LIFT.CAM")])


@pytest.mark.manual("PD-181", "PD-182")
def test_an_axis_of_the_controller_follows_its_encoders() -> None:
    bench = Bench(
        simulated=("Belt",), logic_encoders=["Master"], master_encoders={"Film": "film.position"},
        parameters={"Belt.FeedConst": 500.0},
    ).boot().enable("Belt")  # fmt: skip
    system = SystemMotion(bench.max4.firmware.system, bench.max4.firmware.disk)
    libraries = {library.name: library for library in motion_libraries(system)}
    cam = libraries["VarioCam.lib"]
    tree, belt = bench.max4.firmware.tree, bench.axis("Belt")
    (straight,) = cam.functions["profilload"].run("straight")  # type: ignore[misc]
    for number, (encoder, wire) in enumerate((("Master", ""), ("Film", "film.position"))):
        begin = belt.position
        pins = (belt.log_adr, tree.object(encoder).log_adr, straight, 0.0, 0.0, 1.0, 2.0, 0.0, 0.0, False, False)
        assert cam.blocks["cam"].run(number, *pins, 1, 0.0, 1, 0.0, True)[0] == 0  # type: ignore[index]
        if wire:
            bench.signal(wire, 10.0)
        else:
            bench.set("Master.Position", 10.0)
        bench.run(20)
        assert belt.position - begin == 10 * 2 * 1_000_000 / 500
    assert (CYCLE_NS, bench.max4.firmware.cycle_ns) == (4_000_000, S // 250)
