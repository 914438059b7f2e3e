"""EDS and DCF files of other makers' drives: each runs, has what it declares, and passes our conformance cases.

The expected facts are read from the files: device type (1000h), modes (6502h, or else the objects that there are), the
increments of 608Fh, and oddities with their lines.  The files are not part of the project; `FIELDRIG_DRIVE_FILES` names
the folder that has them, or it is `shared/eds/drives` beside a folder above this one.
"""

import os
from pathlib import Path
from typing import NamedTuple

import pytest
from single_drive_bench import SingleDriveBench

from fieldrig.config.rig_file import from_dict, load
from fieldrig.text.device_names import name_for
from fieldrig.virtual.rig import Rig
from fieldrig_devices.begin.eds_rig import content_for
from fieldrig_devices.cia402.single.foreign import declared
from fieldrig_devices.cia402.single.oddities import oddities
from fieldrig_devices.conformance.description import Description
from fieldrig_devices.conformance.run import choose, conform_virtual
from fieldrig_devices.conformance.suite import Verdict

pytestmark = pytest.mark.long

PLACES = [parent / "shared" / "eds" / "drives" for parent in Path(__file__).parents]
FOLDER = Path(os.environ.get("FIELDRIG_DRIVE_FILES", next((path for path in PLACES if path.is_dir()), "no-folder")))


class Facts(NamedTuple):
    device_type: int
    modes: set[int]
    increments: int
    oddity: str
    """The beginning of one of the findings, with its line."""


ALL = {1, 2, 3, 4, 6, 7, 8, 9, 10}
USUAL = 4_096
FILES = {
    "CANOPEN-SDK--ZeroErr_Driver_V1.5.eds": Facts(0x00420192, {1, 3, 4, 8, 9, 10}, USUAL, "60C1:01 is INTEGER16"),
    "CANOPEN-SDK--elmo.dcf": Facts(0x00000192, ALL - {2}, USUAL, "60E3:01 is UNSIGNED8"),
    "EPOS_Canopen--maxon-70_10.eds": Facts(0x00020192, {1, 3, 6, 8, 9} , USUAL, ""),
    "Eyou_Canopen_master--YiyouServo_V1.4.eds": Facts(0x00020192, ALL - {2, 6}, USUAL, "6072:00 is INTEGER16"),
    "canopen--e35.eds": Facts(0x00020192, ALL | {-2, -1}, 2_000, "60B2:00 is INTEGER32"),
    "cob_robots--Elmo.dcf": Facts(0x00000192, ALL - {2}, USUAL, "6502h (supported drive modes) has no default"),
    "cob_robots--ElmoSimplIQ.dcf": Facts(0x00020192, {1, 3, 4, 6, 7}, USUAL, "6083:00 is 0"),
    "cob_robots--Schunk_0_63.dcf": Facts(0, {1, 2, 7}, USUAL, "the device type 0x00000000"),
    "emec-drv-canopen-tester--emecdrv5.eds": Facts(0x92020100, {1, 8}, USUAL, "the device type 0x92020100"),
    "husarion_ugv_ros--roboteq_motor_controllers_v80_21a.eds": Facts(
        0x192, ALL - {6, 7}, USUAL, "the file describes several axes"
    ),
    "kacanopen--605.3150.51-V-EK-2-60.eds": Facts(0x00020192, {-1, 1, 3, 6, 8, 9}, 2_048, ""),
    "kacanopen--605.3150.55-D-EK-2-60.eds": Facts(0x00020192, {-1, 1, 3, 6, 8, 9}, 2_048, "6060h is not mappable"),
    "kacanopen--605.3150.67-B-EK-2-60.eds": Facts(0x00420192, {*range(-9, 0), 1, 3, 6}, 3_000, "607F:00 is 0"),
    "kacanopen--605.3150.71-A-EK-3-60.eds": Facts(0x00020192, {-1, 1, 3, 6, 8, 9}, 2_048, ""),
    "kacanopen--epos2_347717.eds": Facts(0, {1, 3, 6, 8, 9}, USUAL, "the device type 0x00000000"),
    "maxon_epos4_ros1--epos4_50_15_can_ec90flat_gp52c_mile800_node1.dcf": Facts(
        0x00020192, {1, 3, 6, 8, 9, 10}, USUAL, ""
    ),
    "pilz_robots--prbt_0_1.dcf": Facts(0, {1, 2, 7}, USUAL, "the device type 0x00000000"),
    "ros2_canopen--fake_slaves-cia402_slave.eds": Facts(0xFFFF0192, {1, 3, 6, 8}, USUAL, ""),
    "ros2_canopen--robot_control-cia402_slave.eds": Facts(0x00060192, {1, 3, 6, 7}, USUAL, "6083:00 is 0"),
    "ros_canopen_demo_JetsonTX2_RoboteqSDC3260--roboteq_motor_controllers_v60.eds": Facts(
        0, set(), USUAL, "the object is missing"
    ),
}  # fmt: skip
MEASURED = {"CANOPEN-SDK--elmo.dcf": {"4.2", "4.8"}, "cob_robots--Elmo.dcf": {"4.2", "4.8"}}
"""Cases that compare 6079h with its default 0, which these files give though it is a measured voltage."""
EACH = pytest.mark.parametrize("name", FILES)
MOVES = [name for name, facts in FILES.items() if 1 in facts.modes]


def path_of(name: str) -> Path:
    if not (FOLDER / name).is_file():
        pytest.skip(f"{name} is not here")
    return FOLDER / name


@EACH
def test_a_file_declares_its_modes_and_its_encoder(name: str) -> None:
    path, facts = path_of(name), FILES[name]
    said = declared(path)
    assert set(said.behaviour.modes or ()) == facts.modes
    assert said.increments == facts.increments
    assert any(facts.oddity in finding.what and finding.line > 0 for finding in oddities(path)) or not facts.oddity


@pytest.mark.parametrize("name", MOVES)
def test_a_master_moves_the_drive_of_a_file(name: str) -> None:
    path, facts = path_of(name), FILES[name]
    bench = SingleDriveBench(eds=str(path))
    assert bench.get(0x1000) & 0xFFFF_FFFF == facts.device_type
    if bench.try_get(0x6081) == 0:
        bench.put(0x6081, 2_000)
    bench.enabled(1)
    begin = bench.get(0x6064)
    bench.put(0x607A, begin + 100).control(0x1F)
    bench.until(lambda: bench.get(0x6064) >= begin + 99, 20_000)
    assert bench.status(0x0008) == 0


@EACH
def test_the_drive_of_a_file_conforms(name: str) -> None:
    """All cases but 1.0, which is about the file itself."""
    device = {"kind": "cia402.drive", "node_id": 3, "eds": str(path_of(name)), "links": {"can": "can0"}}
    buses = {"can0": {"kind": "can.virtual", "bitrate": 1_000_000}}
    rig = Rig(from_dict({"time": "virtual", "buses": buses, "devices": {"axis": device}}))
    cases = [case for case in choose([]) if case.number != "1.0"]
    report = conform_virtual(rig, "can0", Description(path_of(name), 3), cases)
    assert {result.case.number for result in report.of(Verdict.FAILED)} == MEASURED.get(name, set())
    assert len(report.of(Verdict.PASSED)) > 40


@EACH
def test_a_rig_is_made_from_a_file_and_its_oddities_are_warned_of(name: str, tmp_path: Path) -> None:
    for file, content in content_for(path_of(name)).items():
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_bytes(content)
    rig = load(tmp_path / f"{name_for(path_of(name))}.yaml", ["time=virtual"])
    (device,) = rig.devices.values()
    is_a_drive = FILES[name].device_type & 0xFFFF == 402 or FILES[name].modes
    assert device.kind == ("cia402.drive" if is_a_drive else "canopen.node")
    warned = {doubt.what for doubt in device.settings.doubts()}
    assert not is_a_drive or warned >= {finding.what for finding in oddities(path_of(name))}


@pytest.mark.parametrize("name", [name for name in FILES if "epos" in name.lower()])
def test_velocities_are_in_the_unit_of_the_file(name: str) -> None:
    """These files say turns per minute, by 608Ch (A4h) or by 60A9h (00B44700h)."""
    bench = SingleDriveBench(eds=str(path_of(name)))
    bench.enabled(3).put(0x60FF, 300).after(3_000)
    assert bench.read("speed") == pytest.approx(300, rel=0.01)
    assert bench.get(0x606C) == pytest.approx(300, abs=3)
